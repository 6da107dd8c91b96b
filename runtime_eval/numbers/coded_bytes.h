// Compresses the bytes of a tensor by the range coder, with a model for each column of a table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlg {

inline constexpr size_t kMaxCodedBytes = 0xffffffff;

// columns   which model a byte is coded by, as many as bytes, each < 2^16; none: one for all. Who decodes has to know them
// returns   nothing of no bytes
std::vector<uint8_t> codedBytes(const std::vector<uint8_t>& bytes, const std::vector<uint16_t>& columns = {});

// The inverse. Memory: at most 50 times as much as there is.
// most      bytes
// returns   false where codedBytes with these columns gives other bytes, or more of them; then *bytes is empty
bool decodeBytes(const std::vector<uint8_t>& coded, const std::vector<uint16_t>& columns, std::vector<uint8_t>* bytes,
                 size_t most = kMaxCodedBytes);

}  // namespace nlg
