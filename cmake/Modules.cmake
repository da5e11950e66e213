# One OBJECT library per folder of src/, so that each part builds and is tested alone with just what
# it may use; libgprodom is all of them.

# Settings shared by everything that is compiled here.
add_library(gprodom_settings INTERFACE)
target_compile_features(gprodom_settings INTERFACE cxx_std_17)
target_compile_options(gprodom_settings INTERFACE -Wall -Wextra -Werror)
target_include_directories(gprodom_settings INTERFACE
  ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src ${PROJECT_BINARY_DIR}/generated)

# gprodom_module(NAME LIBRARIES...): src/NAME/*.cpp as OBJECT library gprodom_NAME.
function(gprodom_module name)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
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

# gprodom_test(NAME MODULES...): test/cpp/NAME/*_test.cpp as one executable test_NAME that links the
# named modules and test/cpp/support only.
function(gprodom_test name)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/cpp/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  gprodom_existing(libraries ${ARGN} gprodom_test_support)
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE gprodom_settings ${libraries} GTest::gtest_main)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/test/cpp)
  target_compile_definitions(test_${name} PRIVATE GPRODOM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  set_target_properties(test_${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test)
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} PROPERTIES TIMEOUT 900)
endfunction()
