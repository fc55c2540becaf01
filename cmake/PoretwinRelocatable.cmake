# Libraries whose code the shared library takes up as well. No function of ours is to be replaced from outside, so that calls are inlined as in
# any other build.
function(poretwin_relocatable target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
endfunction()
