// ZIP archives for fuzz targets: written without compression, and their checksums put right after mutations.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace nlg::fuzz {

// An archive of stored files; the same bytes always.
std::string zipOf(const std::vector<std::pair<std::string, std::string>>& files);

// Gives every stored entry of the central directory the checksum of its bytes: a mutation of a file would otherwise end there.
void putZipChecksumsRight(std::string* archive);

}  // namespace nlg::fuzz
