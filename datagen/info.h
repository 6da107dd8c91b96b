// nlg-datagen info: what a shard is, and whether all of it is sound.
#pragma once

#include <string>
#include <vector>

namespace nlg {

struct InfoRequest {
  std::vector<std::string> paths;
  bool json = false;   // one line of JSON a shard instead of text for people
  bool quiet = false;  // print nothing: only verify
};

// Verifies each shard, in bounded memory, and says what it is on stdout: the SHA-256 of the file, checksums and contract of all
// values, counts that add up, and that no two of its functions are duplicates by its own rule.
// throws   InputError at the first shard that does not hold
void describeShards(const InfoRequest& request);

}  // namespace nlg
