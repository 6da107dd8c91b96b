// Files whose bytes a test changes: with a digest that fits again, or without one.
#pragma once

#include <cstring>
#include <string>

#include "runtime_eval/weights_file/safetensors_layout.h"

namespace nlg {

// The file with the digest of its present bytes, so that what stands behind the digest is asked.
inline std::string stamped(std::string file) {
  stampDigest(&file);
  return file;
}

// The same file without its digest: spaces at the end of the header make up for the key.
inline std::string withoutDigest(std::string file) {
  uint64_t header_length = 0;
  std::memcpy(&header_length, file.data(), sizeof header_length);
  const size_t header_end = sizeof header_length + header_length;
  const size_t key = file.find("\"" + std::string(kDigestKey) + "\":\"");
  size_t entry_end = file.find('"', key + std::strlen(kDigestKey) + 4) + 1;
  if (file[entry_end] == ',') ++entry_end;
  file.insert(header_end, entry_end - key, ' ');
  file.erase(key, entry_end - key);
  return file;
}

}  // namespace nlg
