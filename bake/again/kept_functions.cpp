#include "bake/again/kept_functions.h"

#include <cstring>

#include "runtime_eval/weights_file/sha256.h"

namespace nlg {

KeptKey keyOf(const StoredFunction& function) {
  Sha256 digest;
  digest.add(function.phi, kSupportPointCount);
  digest.add(function.validity, kValidityByteCount);
  digest.add(function.blend_sum, kSupportPointCount);
  const Sha256Digest bytes = digest.finish();
  KeptKey key;
  std::memcpy(key.data(), bytes.data(), sizeof key);
  return key;
}

}  // namespace nlg
