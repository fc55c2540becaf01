# One place for the compiler's strictness; every target of ours links poretwin_warnings.
add_library(poretwin_warnings INTERFACE)
target_compile_options(poretwin_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  -Wcast-qual -Wformat=2 -Werror
  # Divisions and square roots need no errno and no trapping; everything else stays IEEE,
  # because NaN checks at the border must keep working.
  -fno-math-errno -fno-trapping-math)
# gcc 12 warns falsely about std::strings that are joined and moved (bugs 105329, 105562, 105651); most of it lies in the library's headers, which
# precompiling stops it from overlooking.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(poretwin_warnings INTERFACE -Wno-restrict -Wno-array-bounds -Wno-stringop-overread -Wno-stringop-overflow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # gcc collects its garbage less often: quicker to build, for some 200 MB more.
  target_compile_options(poretwin_warnings INTERFACE --param=ggc-min-expand=300 --param=ggc-min-heapsize=600000)
  # Several files as one unit (CMAKE_UNITY_BUILD): gcc takes each for a header, whose anonymous namespace it warns about.
  if(CMAKE_UNITY_BUILD)
    target_compile_options(poretwin_warnings INTERFACE -Wno-subobject-linkage)
  endif()
endif()
# For what computes nothing that takes time: the command line, mocks. A third quicker to build.
add_library(poretwin_light INTERFACE)
target_compile_options(poretwin_light INTERFACE $<$<CONFIG:Release>:-O1>)
