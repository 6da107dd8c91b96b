# find_package(nlg): nlg::runtime_eval. Needs Highway (libhwy-dev) and nothing else.
include(${CMAKE_CURRENT_LIST_DIR}/highway.cmake)
if(NOT TARGET hwy::hwy)
  set(nlg_FOUND FALSE)
  set(nlg_NOT_FOUND_MESSAGE "nlg::runtime_eval needs Highway (Debian: libhwy-dev)")
  return()
endif()
include(${CMAKE_CURRENT_LIST_DIR}/nlg-targets.cmake)
