# A Debian package and an archive that may be unpacked anywhere, both of what `cmake --install` leaves. workflow/package.sh makes them.
# Libraries are Debian's own, on which the package depends; the archive needs them too.
#
#   PREFIX/share/neural-light-grid/samples/
#   PREFIX/share/doc/nlg/                   pages, copyright
#   PREFIX/share/doc/nlg/licences/          of what is compiled in: headers of libraries, three.js in the page of nlg-view
set(doc ${CMAKE_INSTALL_DATAROOTDIR}/doc/nlg)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/nlg DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/samples DESTINATION ${CMAKE_INSTALL_DATADIR}/neural-light-grid)
file(CONFIGURE OUTPUT completion CONTENT "source <(nlg completion bash)\n")
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME nlg)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${doc})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${doc} PATTERN results EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${doc})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${doc} RENAME copyright)
install(FILES ${PROJECT_SOURCE_DIR}/viewer/page/built/three.LICENSE DESTINATION ${doc}/licences RENAME three.js)
# of every library that is compiled against, as Debian states it: a list of those with code in headers would go stale
if(EXISTS /etc/debian_version)
  file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/packages.txt packages REGEX "^[a-z0-9+-]+-dev$")
  foreach(package IN LISTS packages)
    install(FILES /usr/share/doc/${package}/copyright DESTINATION ${doc}/licences RENAME ${package})
  endforeach()
  install(FILES /usr/share/common-licenses/Apache-2.0 DESTINATION ${doc}/licences)
endif()

set(CPACK_GENERATOR DEB TZST)
set(CPACK_PACKAGE_NAME nlg)
set(CPACK_PACKAGE_VENDOR "The neural-light-grid authors")
set(CPACK_PACKAGE_CONTACT ${CPACK_PACKAGE_VENDOR})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "bakes game levels into light grids that do not leak")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/package)
set(CPACK_PACKAGE_FILE_NAME nlg-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_STRIP_FILES ON)
# whatever the umask
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package_times.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# for find_package(nlg)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "cmake, g++, libhwy-dev")
include(CPack)

# Training, as packages of their own (workflow/package.sh --training), of the component `training`, which nothing else installs: libtorch, and
# what of a checkout a run reads.
#
#   PREFIX/lib/nlg-training/    pipeline.sh, its rules, scripts and configurations; bin/
if(NLG_BUILD_TRAINING)
  set(training lib/nlg-training)
  set(component COMPONENT training EXCLUDE_FROM_ALL)
  install(TARGETS nlg-datagen nlg-pca nlg-cache nlg-train nlg-export nlg-bake nlg-validate RUNTIME DESTINATION ${training}/bin ${component})
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/pipeline.sh DESTINATION ${training} ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/pipeline.yaml DESTINATION ${training} ${component})
  foreach(folder workflow tool configs validate/report validate/stability)
    cmake_path(GET folder PARENT_PATH parent)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${training}/${parent} USE_SOURCE_PERMISSIONS ${component}
      FILES_MATCHING REGEX "\\.(py|sh|json|yaml|j2|css|js)$|/Snakefile$" PATTERN __pycache__ EXCLUDE)
  endforeach()
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/nlg-training RENAME copyright ${component})
  if(EXISTS /etc/debian_version)
    file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/packages.txt packages REGEX "^[a-z0-9+-]+-dev( train)?$")
    foreach(package IN LISTS packages)
      string(REPLACE " train" "" package ${package})
      install(FILES /usr/share/doc/${package}/copyright DESTINATION share/doc/nlg-training/licences RENAME ${package} ${component})
    endforeach()
  endif()
  file(WRITE ${PROJECT_BINARY_DIR}/CPackTraining.cmake "include(${PROJECT_BINARY_DIR}/CPackConfig.cmake)
set(CPACK_INSTALL_CMAKE_PROJECTS \"${PROJECT_BINARY_DIR};nlg;training;/\")
set(CPACK_PACKAGE_NAME nlg-training)
set(CPACK_PACKAGE_FILE_NAME nlg-training-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY \"trains and validates generators of weighting functions\")
set(CPACK_DEBIAN_PACKAGE_DEPENDS \"snakemake, python3-yaml, python3-matplotlib, python3-h5py, python3-jinja2, python3-scipy\")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS nlg)
")
endif()
