# One place for the compiler's strictness; every target of ours links poretwin_warnings.
add_library(poretwin_warnings INTERFACE)
target_compile_options(poretwin_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  -Wcast-qual -Wformat=2 -Werror
  # Divisions and square roots need no errno and no trapping; everything else stays IEEE,
  # because NaN checks at the border must keep working.
  -fno-math-errno -fno-trapping-math)
