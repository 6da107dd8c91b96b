// The generator: a network that predicts theta, the parameters of a weighting function, in one pass.
//
// It runs weights of nlg-export (docs/reference/formats.md lists the tensors). Nothing here throws but for memory, and nothing
// allocates after load. A Generator is constant: any number of threads may use one, each with its own GeneratorScratch. Copies
// share the weights. See examples/bake_minimal.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "nlg/representation.h"
#include "nlg/result.h"

namespace nlg {

struct GeneratorData;
class GeneratorScratch;

class Generator {
 public:
  // Makes a generator without weights, for load and parse. Its other functions must not be called.
  Generator() = default;
  explicit Generator(const GeneratorData& data);

  // Reads a weights file, or its bytes, and verifies every byte. The first call sets the SIMD target that the environment
  // variable NLG_SIMD names (simd.h), and should precede the work of other threads.
  //
  // path        as "weights/tent_mlp4.safetensors"
  // generator   changed only on success
  // returns     ok; otherwise the status and one line that says where and why. simd_unavailable: NLG_SIMD names no target of this
  //             machine
  static FileResult load(const std::string& path, Generator* generator);
  static FileResult parse(std::string_view bytes, Generator* generator);

  // Returns the representation that theta is of. D = representation().thetaCount().
  const Representation& representation() const;
  // Returns D floats: the start of fits that use no prediction.
  const float* theta0() const;
  // Returns whether the weights are for a last layer that is solved exactly for each function.
  bool exactLastLayer() const;

  // Predicts theta of `count` functions. The theta of a function depends on the function, the weights and the SIMD target, not on
  // the other functions of the call. It is neither checked nor fitted: ThetaPolicy (policy.h) does both.
  //
  // phi       count x P, in the order of supportPattern(): bytes round(255 phi), or floats in [0, 1]; 0 at points in solid
  // theta     count x D, overwritten
  // scratch   made for this generator
  void generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const;
  void generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const;

 private:
  friend class GeneratorScratch;
  struct Network;
  template <class Sample>
  void generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const;

  std::shared_ptr<const Network> network_;
};

// Working memory of one thread for one generator, 3 MB.
class GeneratorScratch {
 public:
  explicit GeneratorScratch(const Generator& generator);
  ~GeneratorScratch();
  GeneratorScratch(GeneratorScratch&&) noexcept;
  GeneratorScratch& operator=(GeneratorScratch&&) noexcept;

 private:
  friend class Generator;
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace nlg
