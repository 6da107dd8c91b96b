// nlg-datagen info: what a shard is, and whether all of it is sound.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace nlg {

// Verifies a shard, in bounded memory, and says what it is: the SHA-256 of the file, checksums and contract of all values, counts
// that add up, and that no two of its functions are duplicates by its own rule.
// throws   DamageError when its own bytes prove that it is damaged, and the system gives every one of them; InputError when it does
//          not hold otherwise: that the system refuses to read, that another tool or version wrote, or that is whole and breaks the
//          contract
nlohmann::ordered_json describeShard(const std::string& path);

}  // namespace nlg
