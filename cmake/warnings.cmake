# Warnings for our own code, on an interface target: nothing global.
add_library(nlg_warnings INTERFACE)
# GCC 12 sees overlapping copies in std::string where there are none (GCC bug 105651)
target_compile_options(nlg_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
