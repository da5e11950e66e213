# Generates C++ headers and Python modules from lcmtypes/*.lcm.
#   C++     #include "lcmtypes/gprodom/imu_t.hpp"       (target gprodom_lcmtypes)
#   Python  gprodom.lcmtypes.gprodom.imu_t              (in GPRODOM_PYTHON_OUTPUT)
file(GLOB lcm_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lcmtypes/*.lcm)
set(lcm_cpp_root ${PROJECT_BINARY_DIR}/generated)
set(lcm_stamp ${PROJECT_BINARY_DIR}/generated/lcmtypes.stamp)

set(lcm_headers)
foreach(file IN LISTS lcm_files)
  file(STRINGS ${file} package_line REGEX "^package ")
  string(REGEX REPLACE "^package (.*);.*" "\\1" package "${package_line}")
  file(STRINGS ${file} struct_line REGEX "^struct ")
  string(REGEX REPLACE "^struct ([a-z0-9_]+).*" "\\1" struct "${struct_line}")
  list(APPEND lcm_headers ${lcm_cpp_root}/lcmtypes/${package}/${struct}.hpp)
endforeach()

add_custom_command(
  OUTPUT ${lcm_stamp}
  BYPRODUCTS ${lcm_headers}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${GPRODOM_PYTHON_OUTPUT}/gprodom/lcmtypes
  COMMAND ${LCM_GEN} --cpp --cpp-std c++11 --cpp-hpath ${lcm_cpp_root}/lcmtypes ${lcm_files}
  COMMAND ${LCM_GEN} --python --ppath ${GPRODOM_PYTHON_OUTPUT} --package-prefix gprodom.lcmtypes
          ${lcm_files}
  # The package itself lives in scripts/; only lcmtypes is taken from here.
  COMMAND ${CMAKE_COMMAND} -E rm -f ${GPRODOM_PYTHON_OUTPUT}/gprodom/__init__.py
  COMMAND ${CMAKE_COMMAND} -E touch ${lcm_stamp}
  DEPENDS ${lcm_files}
  COMMENT "Generating LCM types"
  VERBATIM)
add_custom_target(gprodom_lcmtypes_generated ALL DEPENDS ${lcm_stamp})

add_library(gprodom_lcmtypes INTERFACE)
add_dependencies(gprodom_lcmtypes gprodom_lcmtypes_generated)
target_include_directories(gprodom_lcmtypes SYSTEM INTERFACE ${lcm_cpp_root})
# LCM reads and writes doubles through int64_t pointers, which the optimiser else takes for no access.
target_compile_options(gprodom_lcmtypes INTERFACE -fno-strict-aliasing)
target_link_libraries(gprodom_lcmtypes INTERFACE PkgConfig::LCM)
