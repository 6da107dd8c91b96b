#include "datagen/dataset/known_functions.h"

#include <algorithm>

#include "datagen/dataset/duplicate_index.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kMirrorCount = 8;

// The samples of a function's mirror image: whole octants change places.
class MirroredSamples {
 public:
  explicit MirroredSamples(size_t point_count) : point_count_(point_count), row_(point_count + point_count / 8) {}

  // Good until the next call.
  StoredFunction of(const StoredFunction& function, size_t mirror) {
    if (mirror == 0) return function;
    uint8_t* const validity = row_.data() + point_count_;
    const size_t points = point_count_ / kMirrorCount, bytes = points / 8;
    for (size_t octant = 0; octant < kMirrorCount; ++octant) {
      std::copy_n(function.phi + (octant ^ mirror) * points, points, row_.data() + octant * points);
      std::copy_n(function.validity + (octant ^ mirror) * bytes, bytes, validity + octant * bytes);
    }
    return {row_.data(), validity};
  }

 private:
  size_t point_count_;
  std::vector<uint8_t> row_;
};

uint64_t countOf(const std::vector<bool>& bits) { return static_cast<uint64_t>(std::count(bits.begin(), bits.end(), true)); }

}  // namespace

uint64_t KnownFunctions::countInTraining() const { return countOf(in_training); }
uint64_t KnownFunctions::countInTrainingMirrored() const { return countOf(in_training_mirrored); }

// The held-out functions are the indexed ones, since they are the fewer: id = 8 function + mirror.
struct KnownFunctionSearch::Impl {
  Impl(const DuplicateRule& rule, const FunctionSet& set)
      : held_out(set),
        mirrored(static_cast<size_t>(set.point_count)),
        index(rule, set.point_count, [this](uint64_t id) { return image(id); }) {}

  StoredFunction image(uint64_t id) { return mirrored.of(functionAt(held_out, id / kMirrorCount), id % kMirrorCount); }
  // Nothing is left to learn about an image of a function that is known already.
  bool isOpen(uint64_t id) const {
    const uint64_t n = id / kMirrorCount;
    return id % kMirrorCount == 0 ? !known.in_training[n] : !known.in_training_mirrored[n];
  }

  const FunctionSet& held_out;
  MirroredSamples mirrored;
  DuplicateIndex index;
  KnownFunctions known;
};

KnownFunctionSearch::KnownFunctionSearch(const DuplicateRule& rule, const FunctionSet& held_out)
    : impl_(std::make_unique<Impl>(rule, held_out)) {
  NLG_CHECK(held_out.point_count % 64, ==, 0);
  const uint64_t count = held_out.functionCount();
  impl_->known.in_training.assign(count, false);
  impl_->known.in_training_mirrored.assign(count, false);
  for (uint64_t id = 0; id < count * kMirrorCount; ++id) impl_->index.add(impl_->image(id));
}

KnownFunctionSearch::~KnownFunctionSearch() = default;

void KnownFunctionSearch::see(const StoredFunction& training) {
  // a training function equals an image of a held-out one exactly when that one equals the same image of the training function:
  // every mirror is its own inverse, and the rule does not care in which order points come
  impl_->index.forEachMatch(
      training, [this](uint64_t id) { return impl_->isOpen(id); },
      [this](const DuplicateIndex::Match& match) {
        const uint64_t n = match.id / kMirrorCount;
        if (match.id % kMirrorCount == 0) impl_->known.in_training[n] = true;
        impl_->known.in_training_mirrored[n] = true;
      });
}

const KnownFunctions& KnownFunctionSearch::known() const { return impl_->known; }

}  // namespace nlg
