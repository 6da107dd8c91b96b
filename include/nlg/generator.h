// The generator: a network that predicts theta, the parameters that stand for a weighting function, in one pass.
//
// It reads the weights that nlg-export wrote (docs/reference/formats.md lists the tensors). No exceptions but for memory; no allocation after
// load. A Generator is constant: any number of threads may use one, each with a GeneratorScratch of its own. Copies share the weights.
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
  // Without weights: only load and parse may be called.
  Generator() = default;
  explicit Generator(const GeneratorData& data);

  // Reads a weights file, or its bytes, and checks every byte; *generator is changed only on success. Obeys the environment variable NLG_SIMD
  // (simd.h): a name that is no target of this build and machine is refused (simd_unavailable), so the first call should precede other
  // threads' work.
  // path   "weights/tent_mlp4.safetensors"
  static FileResult load(const std::string& path, Generator* generator);
  static FileResult parse(std::string_view bytes, Generator* generator);

  // What theta stands for, and D = representation().thetaCount().
  const Representation& representation() const;
  // D floats: where fits start that take no prediction.
  const float* theta0() const;
  // The generator was trained for a last layer that is solved for each function.
  bool exactLastLayer() const;

  // Predicts theta of `count` functions. A function's theta depends on the function, the weights and the SIMD target, not on the functions
  // beside it. It is neither checked nor fitted: ThetaPolicy (policy.h) does what a bake does.
  // phi       count x P, in the order of supportPattern(); bytes: round(255 phi); floats: phi in [0, 1]
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
