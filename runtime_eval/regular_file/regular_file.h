// Opens files that are read: regular files, and nothing that only has a file's name.
#pragma once

#include <string>

namespace nlg {

// A pipe or a device may keep its reader waiting for ever or never end; every reader here opens its files by this, at once and
// without a moment in which another file could take the path's place. Links are followed.
//
// fault     where there is no descriptor: what stands there instead ("a pipe", "a socket", "a device", "a directory"), or the
//           system's reason
// returns   a descriptor to read from, which the caller closes, or -1
int openRegularFile(const std::string& path, std::string* fault);

}  // namespace nlg
