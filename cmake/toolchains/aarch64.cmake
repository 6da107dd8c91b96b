# 64-bit ARM under Linux, by Debian's g++-aarch64-linux-gnu. What it makes runs here under qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64;-L;/usr/aarch64-linux-gnu)
set(NLG_SYSTEM_ROOT /usr/aarch64-linux-gnu)
include(${CMAKE_CURRENT_LIST_DIR}/find_in_root.cmake)
