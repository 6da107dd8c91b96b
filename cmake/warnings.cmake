# Warnings for our own code, on an interface target: nothing global.
add_library(nlg_warnings INTERFACE)
target_compile_options(nlg_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers)
