# The compiler's warnings and other common options. Every target of this project links poretwin_warnings.
add_library(poretwin_warnings INTERFACE)
target_compile_options(poretwin_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  -Wcast-qual -Wformat=2 -Werror
  # Divisions and square roots set no errno and do not trap. Otherwise arithmetic follows IEEE 754,
  # because the checks for NaN in received fields must keep working.
  -fno-math-errno -fno-trapping-math)
# gcc 12 warns falsely about std::strings that are joined and moved (bugs 105329, 105562, 105651). Most of these warnings concern headers of
# the standard library; with precompiled headers gcc does not suppress them.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(poretwin_warnings INTERFACE -Wno-restrict -Wno-array-bounds -Wno-stringop-overread -Wno-stringop-overflow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # gcc frees its memory less often: builds are quicker, and gcc needs some 200 MB more.
  target_compile_options(poretwin_warnings INTERFACE --param=ggc-min-expand=300 --param=ggc-min-heapsize=600000)
  # With CMAKE_UNITY_BUILD several files are compiled as one. gcc then takes each file for a header, and warns of its anonymous namespace.
  if(CMAKE_UNITY_BUILD)
    target_compile_options(poretwin_warnings INTERFACE -Wno-subobject-linkage)
  endif()
endif()
# For targets without long computations (the command line, mocks): their build takes a third less time.
add_library(poretwin_light INTERFACE)
target_compile_options(poretwin_light INTERFACE $<$<CONFIG:Release>:-O1>)
