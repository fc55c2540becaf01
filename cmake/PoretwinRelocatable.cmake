# For libraries whose code the shared library contains as well. Programs that load the shared library must not replace its functions by
# their own (no semantic interposition), so that the compiler may inline calls as in any other build.
function(poretwin_relocatable target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
endfunction()
