# What `cmake --install` leaves: the bake-time library for find_package(nlg), the weights that ship, and where tools are built those that
# need no libtorch, nlg in front of them, and what cmake/package.cmake adds. `cmake --build … --target installed` builds it.
#
#   PREFIX/include/nlg/           the public headers
#   PREFIX/lib/libnlg_*.a         PREFIX/lib/pkgconfig/nlg.pc
#   PREFIX/bin/nlg.dll, PREFIX/lib/libnlg.dll.a, PREFIX/lib/nlg.def   for Windows alone
#   PREFIX/lib/cmake/nlg/         nlg-config.cmake; no path of the build is in it, so that the prefix can be moved
#   PREFIX/share/neural-light-grid/weights/
#   PREFIX/bin/nlg, nlg-bake, …
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# what a build of single tools lacks (./nlg), before anything is copied
install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\" --build \"${PROJECT_BINARY_DIR}\" --target installed COMMAND_ERROR_IS_FATAL ANY)")

# include/nlg/ is the whole of the public interface; everything else stays behind.
file(GLOB NLG_PUBLIC_HEADERS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/nlg/*)
target_sources(nlg_runtime_eval PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/include FILES ${NLG_PUBLIC_HEADERS})

set(NLG_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/nlg)
set_target_properties(nlg_runtime_eval PROPERTIES EXPORT_NAME runtime_eval)
set_target_properties(nlg_weights_file PROPERTIES EXPORT_NAME weights_file)
set_target_properties(nlg_regular_file PROPERTIES EXPORT_NAME regular_file)
# INCLUDES: a CMake before 3.23 reads no file sets
install(TARGETS nlg_regular_file nlg_weights_file nlg_runtime_eval EXPORT nlg-targets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(TARGET nlg_c)
  target_include_directories(nlg_c INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS nlg_c EXPORT nlg-targets)
  # of which Visual Studio's lib makes an import library of its own
  install(FILES ${PROJECT_BINARY_DIR}/runtime_eval/nlg.def DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
install(EXPORT nlg-targets NAMESPACE nlg:: DESTINATION ${NLG_PACKAGE_FOLDER})
# files stay readable within a major version, calls may change in a minor one: CHANGELOG.md
write_basic_package_version_file(${PROJECT_BINARY_DIR}/nlg-config-version.cmake VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH NLG_INCLUDES_FROM_LIB /${CMAKE_INSTALL_LIBDIR} /${CMAKE_INSTALL_INCLUDEDIR})
configure_file(${PROJECT_SOURCE_DIR}/cmake/nlg.pc.in nlg.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/nlg.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/nlg-config.cmake ${PROJECT_SOURCE_DIR}/cmake/highway.cmake
  ${PROJECT_BINARY_DIR}/nlg-config-version.cmake DESTINATION ${NLG_PACKAGE_FOLDER})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/weights/ DESTINATION ${CMAKE_INSTALL_DATADIR}/neural-light-grid/weights
  FILES_MATCHING PATTERN *.safetensors PATTERN README.md)

add_custom_target(installed DEPENDS nlg_runtime_eval)
function(nlg_install_tool name)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  add_dependencies(installed ${name})
endfunction()
