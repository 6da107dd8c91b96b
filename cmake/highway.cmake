# hwy::hwy, from Highway's own CMake package or from pkg-config: the same when the project is built and when it is used. Where
# neither knows it there is no such target, and whoever included this says so.
find_package(HWY CONFIG QUIET)
if(NOT TARGET hwy::hwy)
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(HWY QUIET IMPORTED_TARGET libhwy)
  endif()
  if(TARGET PkgConfig::HWY)
    # no alias: an exported target names what it links, and an alias would be resolved first
    add_library(hwy::hwy INTERFACE IMPORTED)
    target_link_libraries(hwy::hwy INTERFACE PkgConfig::HWY)
  endif()
endif()
