# Compiles through ccache where it is installed, so that clones and branches share the results of compiling equal files. Paths below the
# clone count as relative; precompiled headers need the sloppiness below. To compile without ccache, set
# -DCMAKE_CXX_COMPILER_LAUNCHER= (empty).
find_program(PORETWIN_CCACHE ccache)
if(PORETWIN_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${PORETWIN_CCACHE})
endif()
