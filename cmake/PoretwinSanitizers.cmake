# PORETWIN_SANITIZE is a list with commas as -fsanitize takes it ("address,undefined", "thread", or empty).
set(PORETWIN_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize takes them")
if(PORETWIN_SANITIZE)
  add_compile_options(-fsanitize=${PORETWIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PORETWIN_SANITIZE})
  add_compile_definitions(PORETWIN_SANITIZED)
endif()
# The build type of the sanitizer presets. Reports contain line numbers and the libraries' own assertions are active, at less build time than
# with -O2 -g. (With -O1 the build takes two thirds longer than with -Og; with -Og the tests run 1.4 times as long.)
set(CMAKE_CXX_FLAGS_SANITIZED "-Og -g1")
set(CMAKE_C_FLAGS_SANITIZED "-Og -g1")
