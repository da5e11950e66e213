# find_package(gprodom): the library as gprodom::gprodom, with its headers.
# find_package(gprodom COMPONENTS factors): gprodom::factors as well, which adds Ceres, for factors
# of one's own (gprodom/user_factor.h).
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
include(${CMAKE_CURRENT_LIST_DIR}/gprodom-targets.cmake)
# Of an installed library the targets' file has seen to it that the library is there. In a build
# folder it may not be built yet.
get_target_property(gprodom_configurations gprodom::gprodom IMPORTED_CONFIGURATIONS)
foreach(configuration IN LISTS gprodom_configurations)
  get_target_property(library gprodom::gprodom IMPORTED_LOCATION_${configuration})
  if(NOT EXISTS ${library})
    set(gprodom_FOUND FALSE)
    set(gprodom_NOT_FOUND_MESSAGE
      "${library} is not built: cmake --build ${CMAKE_CURRENT_LIST_DIR} --target gprodom")
  endif()
endforeach()
if(factors IN_LIST gprodom_FIND_COMPONENTS AND NOT TARGET gprodom::factors)
  find_dependency(glog)
  # The shared library, as libgprodom uses it: Ceres::ceres would add the static one.
  find_library(gprodom_CERES NAMES libceres.so)
  mark_as_advanced(gprodom_CERES)
  if(gprodom_CERES)
    add_library(gprodom::factors INTERFACE IMPORTED)
    target_link_libraries(gprodom::factors INTERFACE gprodom::gprodom ${gprodom_CERES} glog::glog)
    set(gprodom_factors_FOUND TRUE)
  else()
    set(gprodom_FOUND FALSE)
    set(gprodom_NOT_FOUND_MESSAGE "factors need Ceres: install libceres-dev")
  endif()
endif()
