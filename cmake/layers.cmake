# Who may link whom: the one page. Every other arrow is refused when CMake configures.
#
#   nlg_library(NAME SOURCES a.cpp … LINKS nlg::x package::y …)   a static library nlg_NAME with the alias nlg::NAME
#   nlg_tool(NAME SOURCES … LINKS …)                              an executable NAME
#
# Layers, lowest first. A library links what its own line names, nothing else.
set(NLG_MAY_LINK_weights_file  "")
set(NLG_MAY_LINK_runtime_eval  nlg::weights_file hwy::hwy)
set(NLG_MAY_LINK_tool          yaml-cpp CLI11::CLI11 nlohmann_json::nlohmann_json fmt::fmt OpenSSL::Crypto)
set(NLG_MAY_LINK_dataset       nlg::tool hdf5::hdf5)
set(NLG_MAY_LINK_scene         nlg::tool nlg::runtime_eval glm::glm TinyGLTF::TinyGLTF)
set(NLG_MAY_LINK_probes        nlg::scene nlg::runtime_eval)
set(NLG_MAY_LINK_visibility    nlg::scene nlg::runtime_eval embree)
set(NLG_MAY_LINK_weighting     nlg::visibility nlg::probes nlg::runtime_eval)
set(NLG_MAY_LINK_solved        nlg::weighting nlg::visibility nlg::probes nlg::scene nlg::runtime_eval nlg::tool)
set(NLG_MAY_LINK_basis         nlg::dataset nlg::runtime_eval Eigen3::Eigen BLAS::BLAS Threads::Threads)
set(NLG_MAY_LINK_generator     nlg::basis nlg::dataset nlg::runtime_eval nlg::torch)
set(NLG_MAY_LINK_validation    nlg::dataset nlg::runtime_eval nlg::weights_file Threads::Threads)
# tools: the stage's own libraries, and what all tools share
set(NLG_MAY_LINK_nlg-datagen   nlg::scene nlg::probes nlg::visibility nlg::weighting nlg::dataset nlg::runtime_eval nlg::tool)
set(NLG_MAY_LINK_nlg-solve     nlg::solved nlg::tool)
set(NLG_MAY_LINK_nlg-pca       nlg::basis nlg::dataset nlg::runtime_eval nlg::tool)
set(NLG_MAY_LINK_nlg-train     nlg::generator nlg::basis nlg::dataset nlg::runtime_eval nlg::tool nlg::torch)
set(NLG_MAY_LINK_nlg-export    nlg::generator nlg::basis nlg::dataset nlg::weights_file nlg::runtime_eval nlg::tool nlg::torch)
set(NLG_MAY_LINK_nlg-validate  nlg::validation nlg::dataset nlg::weights_file nlg::runtime_eval nlg::tool)

function(nlg_check_links name)
  if(NOT DEFINED NLG_MAY_LINK_${name})
    message(FATAL_ERROR "cmake/layers.cmake has no line for ${name}")
  endif()
  foreach(link IN LISTS ARGN)
    if(NOT link IN_LIST NLG_MAY_LINK_${name})
      message(FATAL_ERROR "${name} may not link ${link}: cmake/layers.cmake allows it [${NLG_MAY_LINK_${name}}]")
    endif()
  endforeach()
endfunction()

function(nlg_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  nlg_check_links(${name} ${ARG_LINKS})
  add_library(nlg_${name} STATIC ${ARG_SOURCES})
  add_library(nlg::${name} ALIAS nlg_${name})
  target_include_directories(nlg_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_compile_features(nlg_${name} PUBLIC cxx_std_20)
  target_link_libraries(nlg_${name} PUBLIC ${ARG_LINKS} PRIVATE $<BUILD_INTERFACE:nlg_warnings>)
endfunction()

function(nlg_tool name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  nlg_check_links(${name} ${ARG_LINKS})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} nlg_warnings)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()
