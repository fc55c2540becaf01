# PORETWIN_SANITIZE is a comma list as -fsanitize takes it ("address,undefined", "thread", or empty).
set(PORETWIN_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize takes them")
if(PORETWIN_SANITIZE)
  add_compile_options(-fsanitize=${PORETWIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PORETWIN_SANITIZE})
  add_compile_definitions(PORETWIN_SANITIZED)
endif()
# The build type of the sanitizer presets: lines in reports and the libraries' own assertions, without the price of -O2 -g. (-O1 takes
# two thirds longer to build than -Og, which runs 1.4 times as long.)
set(CMAKE_CXX_FLAGS_SANITIZED "-Og -g1")
set(CMAKE_C_FLAGS_SANITIZED "-Og -g1")
