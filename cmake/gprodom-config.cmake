# find_package(gprodom): the library as gprodom::gprodom, with its headers.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
include(${CMAKE_CURRENT_LIST_DIR}/gprodom-targets.cmake)
