# RelWithDebInfo unless another is asked for.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()
# Stacks need functions and lines, which -g1 keeps. -g makes object files ten times as large: a check of a
# fresh clone and its packages would take 10 GB more. The Debug build has all.
string(REPLACE "-g " "-g1 " CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")
