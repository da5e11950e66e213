# ccache, shared between checkouts: paths below this one do not count. Precompiled headers, which
# sanitized builds have, take the sloppiness.
find_program(CCACHE ccache)
get_filename_component(checkout ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_BASEDIR=${checkout} CCACHE_NOHASHDIR=1)
  if(GPRODOM_SANITIZE)
    list(APPEND CMAKE_CXX_COMPILER_LAUNCHER CCACHE_SLOPPINESS=pch_defines,time_macros)
  endif()
  list(APPEND CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
