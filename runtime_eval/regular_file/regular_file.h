// Opens regular files for reading, and refuses pipes, devices and folders. The library's only calls to the operating system:
// regular_file.cpp for POSIX, regular_file_windows.cpp for Windows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace nlg {

// A pipe or a device may keep its reader waiting for ever or never end; every reader here opens its files by this, at once and
// without a moment in which another file could take the path's place. Links are followed.
//
// path      in UTF-8 on Windows; elsewhere the bytes that the system keeps
// fault     where there is no descriptor: what stands there instead ("a pipe", "a socket", "a device", "a directory"), or the
//           system's reason
// returns   a descriptor to read from, which the caller closes, or -1
int openRegularFile(const std::string& path, std::string* fault);

void closeRegularFile(int file);

// returns   the bytes of an open file, or -1 with errno as the system's reason
int64_t regularFileSize(int file);

// Reads count bytes from an offset on, from any thread.
// returns   false where the system refuses, or the file ends before
bool readRegularFile(int file, uint64_t offset, void* to, size_t count);

}  // namespace nlg
