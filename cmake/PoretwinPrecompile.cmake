# Headers that nearly every file includes are precompiled once for each kind of target: libraries whose code the shared library contains,
# other libraries, tests (with GoogleTest's header). Files must nevertheless include what they use, since the clang preset builds without
# precompiled headers (CMAKE_DISABLE_PRECOMPILE_HEADERS).
set(PORETWIN_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <optional> <random> <span> <sstream> <string> <thread>
  <vector> <fmt/format.h> <Eigen/Dense>)

# The first target of a kind (relocatable, library or test) precompiles the headers; all other targets of this kind reuse them.
function(poretwin_precompile target kind)
  get_property(maker GLOBAL PROPERTY poretwin_precompiled_${kind})
  if(maker)
    target_precompile_headers(${target} REUSE_FROM ${maker})
    return()
  endif()
  set_property(GLOBAL PROPERTY poretwin_precompiled_${kind} ${target})
  target_precompile_headers(${target} PRIVATE ${PORETWIN_COMMON_HEADERS} ${ARGN})
endfunction()
