# PORETWIN_SANITIZE is a comma list as -fsanitize takes it ("address,undefined", "thread", or empty).
set(PORETWIN_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize takes them")
if(PORETWIN_SANITIZE)
  add_compile_options(-fsanitize=${PORETWIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PORETWIN_SANITIZE})
endif()
