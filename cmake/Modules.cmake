# One OBJECT library per room (folder of src/), so that each is built and tested alone with just the
# rooms before it; libgprodom and each program are all of them.

# Settings shared by everything that is compiled here.
add_library(gprodom_settings INTERFACE)
target_compile_features(gprodom_settings INTERFACE cxx_std_17)
target_compile_options(gprodom_settings INTERFACE -Wall -Wextra -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  # g++ 14 (Debian 13) warns wrongly where a std::variant is moved into a vector. g++ 12 keeps the warning.
  target_compile_options(gprodom_settings INTERFACE -Wno-maybe-uninitialized)
endif()
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # Where every processor has fused multiply-add, as on arm64, g++ would use it unasked, and the numbers
  # would be others than on amd64.
  target_compile_options(gprodom_settings INTERFACE -ffp-contract=off)
endif()
target_include_directories(gprodom_settings INTERFACE
  ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src ${PROJECT_BINARY_DIR}/generated)

# gprodom_module(NAME LIBRARIES...): the sources in src/NAME and its folders as OBJECT library
# gprodom_NAME.
function(gprodom_module name)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(gprodom_${name} OBJECT ${sources})
  target_link_libraries(gprodom_${name} PUBLIC gprodom_settings ${ARGN})
  set_target_properties(gprodom_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL APPEND PROPERTY GPRODOM_MODULES gprodom_${name})
endfunction()

# gprodom_existing(OUT TARGETS...): those of the targets that exist.
function(gprodom_existing out)
  set(found)
  foreach(target IN LISTS ARGN)
    if(TARGET ${target})
      list(APPEND found ${target})
    endif()
  endforeach()
  set(${out} ${found} PARENT_SCOPE)
endfunction()

# gprodom_test(MODULE MODULES...): test/cpp/NAME/*.cpp as executable test_NAME, for MODULE
# gprodom_NAME. It links test/cpp/support and the rooms up to its own of MODULES, which are in order.
function(gprodom_test module)
  string(REPLACE gprodom_ "" name ${module})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/cpp/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  list(FIND ARGN ${module} index)
  math(EXPR count "${index} + 1")
  list(SUBLIST ARGN 0 ${count} rooms)
  gprodom_existing(support gprodom_test_support)
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE gprodom_settings ${rooms} ${support} GTest::gtest_main)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/test/cpp)
  target_compile_definitions(test_${name} PRIVATE GPRODOM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  set_target_properties(test_${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test
    UNITY_BUILD OFF) # each file has a small world of its own, with names that others have too
  add_dependencies(tests test_${name})
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} PROPERTIES TIMEOUT 900)
endfunction()
