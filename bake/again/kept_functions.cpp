#include "bake/again/kept_functions.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "datagen/functions/chunk_codec.h"
#include "runtime_eval/weights_file/sha256.h"

namespace nlg {
namespace {

constexpr float kNoEye = 9.0f;  // beyond every support

KeptKey keyOf(Sha256* digest) {
  const Sha256Digest bytes = digest->finish();
  KeptKey key;
  std::memcpy(key.data(), bytes.data(), sizeof key);
  return key;
}

}  // namespace

KeptKey keyOf(const WeightingBuilder& begun) {
  using Bits = std::array<uint32_t, sizeof(LocalTriangle) / sizeof(uint32_t)>;
  std::vector<Bits> triangles;
  triangles.reserve(begun.visibility().triangles().size());
  for (const LocalTriangle& triangle : begun.visibility().triangles()) triangles.push_back(std::bit_cast<Bits>(triangle));
  // another file may list the same triangles in another order
  std::sort(triangles.begin(), triangles.end());
  const SolidVote& vote = begun.probeVote();
  const std::array<uint8_t, 2> own = {vote.solid(), vote.disputed()};
  Sha256 digest;
  digest.add(own.data(), own.size());
  digest.add(triangles.data(), triangles.size() * sizeof(Bits));
  for (const std::optional<LocalPoint>& eye : begun.neighbours()) {
    const auto bits = std::bit_cast<std::array<uint32_t, 3>>(eye.value_or(LocalPoint{kNoEye, kNoEye, kNoEye}));
    digest.add(bits.data(), sizeof bits);
  }
  return keyOf(&digest);
}

KeptKey keyOf(const StoredFunction& function) {
  Sha256 digest;
  digest.add(function.phi, kSupportPointCount);
  digest.add(function.validity, kValidityByteCount);
  digest.add(function.blend_sum, kSupportPointCount);
  return keyOf(&digest);
}

std::vector<uint8_t> packSamples(const StoredFunction& function) {
  std::vector<uint8_t> samples(kKeptSampleBytes);
  const auto validity = std::copy_n(function.phi, kSupportPointCount, samples.begin());
  std::copy_n(function.blend_sum, kSupportPointCount, std::copy_n(function.validity, kValidityByteCount, validity));
  return encodeChunk(samples.data(), samples.size());
}

bool unpackSamples(const std::vector<uint8_t>& packed, std::vector<uint8_t>* samples) {
  samples->resize(kKeptSampleBytes);
  return decodeChunk(packed.data(), packed.size(), samples->data(), samples->size());
}

KeptIndex::KeptIndex(const KeptProbes& probes) {
  for (const KeptProbe& probe : probes) {
    probes_.emplace(probe.key, &probe);
    if (probe.function) functions_.emplace(probe.function->key, probe.function);
  }
}

const KeptProbe* KeptIndex::findProbe(const WeightingBuilder& begun, const KeptKey& key) const {
  // probes of one support differ in what lies around it
  const auto [first, end] = probes_.equal_range(key);
  const auto found = std::find_if(first, end, [&](const auto& entry) {
    const std::vector<FarQuestion>& asked = entry.second->asked;
    return std::all_of(asked.begin(), asked.end(), [&](const FarQuestion& q) { return begun.visibility().answersAlike(q); });
  });
  return found == end ? nullptr : found->second;
}

std::shared_ptr<KeptFunction> KeptIndex::findFunction(const KeptKey& key) const {
  const auto found = functions_.find(key);
  return found == functions_.end() ? nullptr : found->second;
}

void mergeAlike(KeptProbes* probes) {
  KeptProbes merged;
  std::unordered_multimap<KeptKey, size_t, KeptKeyHash> places;
  std::unordered_map<KeptKey, std::shared_ptr<KeptFunction>, KeptKeyHash> functions;
  for (KeptProbe& probe : *probes) {
    const auto [first, end] = places.equal_range(probe.key);
    if (std::any_of(first, end, [&](const auto& place) { return merged[place.second].asked == probe.asked; })) continue;
    places.emplace(probe.key, merged.size());
    if (probe.function) probe.function = functions.emplace(probe.function->key, probe.function).first->second;
    merged.push_back(std::move(probe));
  }
  *probes = std::move(merged);
}

}  // namespace nlg
