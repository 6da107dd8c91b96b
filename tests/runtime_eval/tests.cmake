# Tests of the library alone. They need GoogleTest and what their lines name: the builds for other machines run them, too.
# what a system has of its own
if(WIN32)
  set(of_system _windows)
endif()
nlg_test(test_weights_file
  SOURCES runtime_eval/weights_file/weights_file_test.cpp runtime_eval/weights_file/tensor_file_test.cpp runtime_eval/weights_file/sha256_test.cpp
    runtime_eval/weights_file/special_files${of_system}_test.cpp
    runtime_eval/numbers/flush_subnormals_test.cpp
    runtime_eval/numbers/half_test.cpp
    runtime_eval/numbers/range_coder_test.cpp
  LINKS nlg::weights_file nlohmann_json::nlohmann_json)
nlg_test(test_runtime_eval
  SOURCES
    runtime_eval/support/support_pattern_test.cpp
    runtime_eval/support/weighting_function_test.cpp
    runtime_eval/simd/simd_target_test.cpp
    runtime_eval/evaluator/evaluate_test.cpp
    runtime_eval/evaluator/theta_form_test.cpp
    runtime_eval/evaluator/matrix_product_test.cpp
    runtime_eval/evaluator/parity_transform_test.cpp
    runtime_eval/evaluator/projection_test.cpp
    runtime_eval/evaluator/generator_test.cpp
    runtime_eval/counting_new.cpp runtime_eval/system_calls${of_system}.cpp
    runtime_eval/evaluator/allocation_test.cpp
    runtime_eval/fit/network_loss_test.cpp
    runtime_eval/fit/reference_loss.cpp
    runtime_eval/fit/normal_equations_test.cpp
    runtime_eval/fit/extreme_fit_test.cpp
    runtime_eval/fit/fit_test.cpp
    runtime_eval/fit/adam_update_test.cpp
    runtime_eval/fit/soap_update_test.cpp
    runtime_eval/fit/last_layer_test.cpp
    runtime_eval/policy/compensated_rounding_test.cpp
    runtime_eval/policy/function_check_test.cpp
    runtime_eval/policy/refinement_test.cpp
    runtime_eval/policy/stage_runner_test.cpp
    runtime_eval/policy/theta_policy_test.cpp
    runtime_eval/policy/representation_choice_test.cpp
    runtime_eval/probe_tree/probe_tree_test.cpp
  LINKS nlg::runtime_eval)
# strict C: the interface's header must hold no C++ (and the warnings of nlg_warnings are for C++)
add_library(c_engine OBJECT runtime_eval/c_api/c_engine.c)
set_target_properties(c_engine PROPERTIES C_STANDARD 11 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
target_include_directories(c_engine PRIVATE ${PROJECT_SOURCE_DIR}/include)
target_compile_options(c_engine PRIVATE -Wall -Wextra -Wpedantic -Werror)
nlg_test(test_c_api SOURCES runtime_eval/c_api/c_api_test.cpp LINKS nlg::runtime_eval c_engine)
nlg_test(test_product_field
  SOURCES
    runtime_eval/support/point_order_test.cpp
    runtime_eval/evaluator/product_field_test.cpp
    runtime_eval/fit/field_loss_test.cpp
    runtime_eval/fit/reference_loss.cpp
    runtime_eval/fit/field_normal_equations_test.cpp
    runtime_eval/fit/symmetric_band_test.cpp
  LINKS nlg::runtime_eval)
nlg_test(test_codes
  SOURCES
    runtime_eval/evaluator/dictionary_test.cpp
    runtime_eval/fit/code_fit_test.cpp
    runtime_eval/policy/code_rounding_test.cpp
  LINKS nlg::runtime_eval)
nlg_test(test_light_grid
  SOURCES
    runtime_eval/counting_new.cpp runtime_eval/system_calls${of_system}.cpp
    runtime_eval/probe_tree/probe_tree_data_test.cpp
    runtime_eval/light_grid/light_grid_test.cpp
    runtime_eval/grid_file/light_records_test.cpp runtime_eval/numbers/coded_bytes_test.cpp
    runtime_eval/light_grid/packed_light_test.cpp
    runtime_eval/light_grid/look_up_test.cpp
    runtime_eval/light_grid/look_up_batch_test.cpp
    runtime_eval/light_grid/resampled_light_test.cpp
    runtime_eval/grid_file/light_grid_file_test.cpp
  LINKS nlg::runtime_eval Threads::Threads nlohmann_json::nlohmann_json)
nlg_test(test_shader_grid SOURCES runtime_eval/shader_grid/shader_grid_test.cpp LINKS nlg::runtime_eval glm::glm)
