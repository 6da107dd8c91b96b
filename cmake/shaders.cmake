# Shaders as SPIR-V, for tests on Vulkan. NLG_HAS_VULKAN: all that is needed is there.
find_package(Vulkan QUIET)
find_program(NLG_GLSLANG glslangValidator)
find_program(NLG_SPIRV_VAL spirv-val)
find_program(NLG_SPIRV_CROSS spirv-cross)
set(NLG_HAS_VULKAN OFF)
if(Vulkan_FOUND AND NLG_GLSLANG AND NLG_SPIRV_VAL AND NLG_SPIRV_CROSS)
  set(NLG_HAS_VULKAN ON)
else()
  message(STATUS "Shaders are not tested on Vulkan: libvulkan-dev, glslang-tools, spirv-tools and spirv-cross are needed")
endif()

# one shader for all grids
set(NLG_EVERY_GRID NLG_NETWORK_4 NLG_NETWORK_44 NLG_NETWORK_88 NLG_FIELD NLG_BRICK NLG_HALVES "NLG_CLASS_COUNT=int(nlgHeader(3).y)")

#   nlg_spirv(OUT SOURCE DEFINE…)    OUT.spv of GLSL that includes look_up.glsl or resampled.glsl
function(nlg_spirv out source)
  list(TRANSFORM ARGN PREPEND -D)
  set(shaders ${PROJECT_SOURCE_DIR}/runtime_eval/shader_grid)
  add_custom_command(OUTPUT ${out}.spv
    COMMAND ${NLG_GLSLANG} --quiet -V --target-env vulkan1.1 -DNLG_NEAR ${ARGN} -I${PROJECT_SOURCE_DIR} -o ${out}.spv ${source}
    COMMAND ${NLG_SPIRV_VAL} --target-env vulkan1.1 ${out}.spv
    DEPENDS ${source} ${shaders}/look_up.glsl ${shaders}/resampled.glsl
    VERBATIM)
endfunction()

#   nlg_spirv_by_hlsl(OUT)           OUT.hlsl.spv of OUT.spv, made HLSL and compiled again
function(nlg_spirv_by_hlsl out)
  add_custom_command(OUTPUT ${out}.hlsl.spv
    COMMAND ${NLG_SPIRV_CROSS} --hlsl --shader-model 60 ${out}.spv --output ${out}.hlsl
    COMMAND ${NLG_GLSLANG} --quiet -D -V --target-env vulkan1.1 -S comp -e main -o ${out}.hlsl.spv ${out}.hlsl
    COMMAND ${NLG_SPIRV_VAL} --target-env vulkan1.1 ${out}.hlsl.spv
    DEPENDS ${out}.spv
    VERBATIM)
endfunction()
