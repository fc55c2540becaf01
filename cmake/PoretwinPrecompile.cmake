# Headers that nearly every file reads are parsed once for each kind of target: libraries that the shared library takes up, other libraries,
# tests (with GoogleTest's). Files include what they use all
# the same: the clang preset builds without (CMAKE_DISABLE_PRECOMPILE_HEADERS).
set(PORETWIN_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <optional> <random> <span> <sstream> <string> <thread>
  <vector> <fmt/format.h> <Eigen/Dense>)

# The first target that asks makes them for all of its KIND (relocatable, library or test).
function(poretwin_precompile target kind)
  get_property(maker GLOBAL PROPERTY poretwin_precompiled_${kind})
  if(maker)
    target_precompile_headers(${target} REUSE_FROM ${maker})
    return()
  endif()
  set_property(GLOBAL PROPERTY poretwin_precompiled_${kind} ${target})
  target_precompile_headers(${target} PRIVATE ${PORETWIN_COMMON_HEADERS} ${ARGN})
endfunction()
