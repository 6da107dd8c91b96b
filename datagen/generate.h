// nlg-datagen's first duty: one scene under one jitter → one shard of weighting functions.
#pragma once

#include <string>

#include "datagen/shards/shard_job.h"

namespace nlg {

// Generates the shard, writes it to path `out`, and prints its counts on stdout as one line of JSON.
// throws   UsageError, InputError (the scene), OutputError (on a full disk it says what was needed and what is free)
void generate(const ShardRequest& request, const std::string& out, const DatagenOptions& options, const OptionTable& table);

}  // namespace nlg
