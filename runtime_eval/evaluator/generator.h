// The generator network at bake time: stored weighting functions in, theta out.
//
// Loads what nlg-export wrote (docs/reference/formats.md lists the tensors). No exceptions; no allocation after load; one Generator may be
// used by any number of threads, each with a scratch of its own.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime_eval/evaluator/layer_stack.h"
#include "runtime_eval/evaluator/projection.h"
#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/weights_file/weights_file.h"

namespace nlg {

// The version of the tensors' meaning, which the reader demands.
inline constexpr int kWeightsVersion = 1;

// The generator's numbers, unfolded. Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width;
// last layer: theta = theta0 + output_scale * (W h + b).
struct GeneratorData {
  Representation representation;
  float slope = 0.01f;  // of the generator's own LeakyReLU
  BasisData basis;
  std::vector<GeneratorLayer> layers;  // the last one has D outputs
  std::vector<float> theta0;           // D
  std::vector<float> output_scale;     // D
  // Networks with a linear output: the generator was trained for a last layer that is solved for each function (fit/last_layer.h).
  bool exact_last_layer = false;
};

// Between file and numbers. The reader checks every shape, range and the support pattern; on failure *data is unspecified.
FileResult generatorFromWeights(const WeightsFile& file, GeneratorData* data);
WeightsFile weightsFromGenerator(const GeneratorData& data);

class GeneratorScratch;

// What a function's theta is depends on the function, the weights and the SIMD target: not on the batch it stands in, its place
// there or the thread.
class Generator {
 public:
  Generator() = default;
  explicit Generator(const GeneratorData& data);

  // Reads a file, or its bytes, and prepares the generator; *generator is changed only on success. Obeys NLG_SIMD
  // (simd_target.h): a name that is no target of this build and machine is refused (simd_unavailable), so the first call should
  // precede other threads' work.
  static FileResult load(const std::string& path, Generator* generator);
  static FileResult parse(std::string_view bytes, Generator* generator);

  const Representation& representation() const { return representation_; }
  const float* theta0() const { return theta0_.data(); }
  bool exactLastLayer() const { return exact_last_layer_; }

  // theta of any number of functions, in batches of kBatchCount. Any number of threads may call it at once, each with a scratch
  // of its own.
  // phi     count x P in pattern order; bytes: round(255 phi); floats: phi in [0, 1]
  // theta   count x D
  void generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const;
  void generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const;

 private:
  friend class GeneratorScratch;
  template <class Sample>
  void generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const;

  Representation representation_;
  Projection projection_;
  LayerStack layers_;
  std::vector<float> theta0_;
  bool exact_last_layer_ = false;
};

// Working memory of one thread, for one generator.
class GeneratorScratch {
 public:
  explicit GeneratorScratch(const Generator& generator);

 private:
  friend class Generator;
  ProjectionScratch projection_;
  LayerScratch layers_;
};

// theta of one function in double, straight from the formulas: what the vector code is tested against. phi: P, in [0, 1].
std::vector<double> generateReference(const GeneratorData& data, const double* phi);

}  // namespace nlg
