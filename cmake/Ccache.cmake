# ccache, shared between checkouts: paths below this one do not count.
find_program(CCACHE ccache)
get_filename_component(checkout ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_BASEDIR=${checkout} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()
