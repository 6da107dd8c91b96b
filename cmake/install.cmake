# What `cmake --install` leaves: the bake-time library for find_package(nlg), the weights that ship, and where tools are built those that
# need no libtorch, nlg in front of them, and what cmake/package.cmake adds. `cmake --build … --target installed` builds it.
#
#   PREFIX/include/nlg/           the include directory; below it headers lie as in the repository
#   PREFIX/lib/libnlg_*.a
#   PREFIX/bin/nlg.dll, PREFIX/lib/libnlg.dll.a, PREFIX/lib/nlg.def   for Windows alone
#   PREFIX/lib/cmake/nlg/         nlg-config.cmake; no path of the build is in it, so that the prefix can be moved
#   PREFIX/share/neural-light-grid/weights/
#   PREFIX/bin/nlg, nlg-bake, …
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Headers that a baker includes, and those that these include. Kernels (-inl.h), the parts of the loss and what only files or tests
# need stay behind.
target_sources(nlg_weights_file PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES
  ${PROJECT_SOURCE_DIR}/runtime_eval/weights_file/file_result.h
  ${PROJECT_SOURCE_DIR}/runtime_eval/weights_file/weights_file.h)
set(NLG_PUBLIC_HEADERS
  c_api/nlg.h
  numbers/half.h
  simd/aligned.h
  simd/simd_target.h
  support/support_pattern.h
  support/point_order.h
  support/loss_weights.h
  support/stored_function.h
  support/weighting_function.h
  evaluator/dictionary.h
  evaluator/representation.h
  evaluator/evaluate.h
  evaluator/matrix_product.h
  evaluator/parity_transform.h
  evaluator/projection.h
  evaluator/layer_stack.h
  evaluator/generator.h
  fit/fit_result.h
  fit/symmetric_band.h
  fit/normal_equations.h
  fit/adam.h
  fit/adam_update.h
  fit/soap_update.h
  fit/code_fit.h
  fit/levenberg_marquardt.h
  fit/direct.h
  fit/policy_options.def
  fit/policy_options.h
  fit/function_check.h
  fit/refinement.h
  fit/representation_choice.h
  fit/theta_stage.h
  fit/theta_record.h
  fit/theta_batch.h
  fit/stage_plan.h
  fit/stage_runner.h
  fit/theta_rounding.h
  fit/theta_policy.h
  light_grid/probe_tree.h
  light_grid/light_grid.h
  light_grid/spherical_harmonics.h
  light_grid/packed_light.h
  light_grid/irradiance.h
  light_grid/resampled_light.h
  light_grid/light_grid_file.h
  shader_grid/shader_grid.h)
list(TRANSFORM NLG_PUBLIC_HEADERS PREPEND ${PROJECT_SOURCE_DIR}/runtime_eval/)
target_sources(nlg_runtime_eval PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${NLG_PUBLIC_HEADERS})

set(NLG_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/nlg)
set_target_properties(nlg_runtime_eval PROPERTIES EXPORT_NAME runtime_eval)
set_target_properties(nlg_weights_file PROPERTIES EXPORT_NAME weights_file)
set_target_properties(nlg_regular_file PROPERTIES EXPORT_NAME regular_file)
# INCLUDES: a CMake before 3.23 reads no file sets
install(TARGETS nlg_regular_file nlg_weights_file nlg_runtime_eval EXPORT nlg-targets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/nlg
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/nlg)
if(TARGET nlg_c)
  target_include_directories(nlg_c INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/nlg>)
  install(TARGETS nlg_c EXPORT nlg-targets)
  # of which Visual Studio's lib makes an import library of its own
  install(FILES ${PROJECT_BINARY_DIR}/runtime_eval/nlg.def DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
install(EXPORT nlg-targets NAMESPACE nlg:: DESTINATION ${NLG_PACKAGE_FOLDER})
# before 1.0 every minor version may change what headers hold
write_basic_package_version_file(${PROJECT_BINARY_DIR}/nlg-config-version.cmake VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/nlg-config.cmake ${PROJECT_SOURCE_DIR}/cmake/highway.cmake
  ${PROJECT_BINARY_DIR}/nlg-config-version.cmake DESTINATION ${NLG_PACKAGE_FOLDER})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/weights/ DESTINATION ${CMAKE_INSTALL_DATADIR}/neural-light-grid/weights
  FILES_MATCHING PATTERN *.safetensors PATTERN README.md)

add_custom_target(installed DEPENDS nlg_runtime_eval)
function(nlg_install_tool name)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  add_dependencies(installed ${name})
endfunction()
