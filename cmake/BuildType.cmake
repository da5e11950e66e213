# RelWithDebInfo unless another is asked for.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()
# Stacks need functions and lines, which -g1 keeps. -g makes object files ten times as large: a check of a
# fresh clone and its packages would take 10 GB more. The Debug build has all.
string(REPLACE "-g " "-g1 " CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")

# Eight sources of a target are compiled as one: most of the compiler's time goes into the headers of Eigen
# and Ceres. So no two sources of a room have a constant of the same name, and that each source includes
# what it uses is seen by scripts/clang_tidy.py. OFF is quicker after a change of one file.
option(CMAKE_UNITY_BUILD "Compile several sources of a target as one" ON)
