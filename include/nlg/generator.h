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
#include "nlg/support.h"

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

  // Returns whether the network reads samples, so that generate takes VisibilitySamples.
  bool readsSamples() const;

  // Predicts theta of `count` functions. The theta of a function depends on the function, the weights and the SIMD target, not on
  // the other functions of the call. It is neither checked nor fitted: ThetaPolicy (policy.h) does both.
  //
  // functions   phi and validity are read, nothing else
  // theta       count x D, overwritten
  // scratch     made for this generator
  void generate(const StoredFunction* functions, int count, float* theta, GeneratorScratch* scratch) const;
  // The same of what a probe sees at the sample points, without phi: 1,024 rays take the place of a function. Only if readsSamples().
  void generate(const VisibilitySamples* functions, int count, float* theta, GeneratorScratch* scratch) const;

 private:
  friend class GeneratorScratch;
  struct Network;
  template <class Function>
  void generateAll(const Function* functions, int count, float* theta, GeneratorScratch* scratch) const;

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
