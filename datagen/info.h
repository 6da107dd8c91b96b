// nlg-datagen info: what a shard is, and whether all of it is sound.
#pragma once

#include <string>
#include <vector>

#include "tool/error.h"

namespace nlg {

// A shard whose own bytes prove that it is damaged, and every byte of which the system gives: exit code damaged_file, so that the
// workflow may put it aside and make it again.
class DamagedShard : public ToolError {
 public:
  explicit DamagedShard(const std::string& line) : ToolError(ExitCode::damaged_file, line) {}
};

struct InfoRequest {
  std::vector<std::string> paths;
  bool json = false;   // one line of JSON a shard instead of text for people
  bool quiet = false;  // print nothing: only verify
};

// Verifies each shard, in bounded memory, and says what it is on stdout: the SHA-256 of the file, checksums and contract of all
// values, counts that add up, and that no two of its functions are duplicates by its own rule.
// throws   DamagedShard at the first shard that is proven damaged, InputError at the first that does not hold otherwise: that the
//          system refuses to read, that another tool or version wrote, or that is whole and breaks the contract
void describeShards(const InfoRequest& request);

}  // namespace nlg
