// The generator network at bake time: stored weighting functions in, theta out.
//
// Loads what nlg-export wrote (docs/formats.md lists the tensors). No exceptions; no allocation after load; one Generator may be
// used by any number of threads, each with a scratch of its own.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "export/weights_file/weights_file.h"
#include "runtime_eval/evaluator/projection.h"
#include "runtime_eval/evaluator/representation.h"

namespace nlg {

// The version of the tensors' meaning that this code writes and the newest that it reads.
inline constexpr int kWeightsVersion = 1;

// One layer as the file holds it.
struct GeneratorLayer {
  int input_count = 0, output_count = 0;
  std::vector<float> weight;  // outputs x inputs
  std::vector<float> bias;    // outputs
};

// The generator's numbers, unfolded. Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width;
// last layer: theta = theta0 + output_scale * (W h + b).
struct GeneratorData {
  Representation representation;
  float slope = 0.01f;  // of the generator's own LeakyReLU
  BasisData basis;
  std::vector<GeneratorLayer> layers;  // the last one has D outputs
  std::vector<float> theta0;           // D
  std::vector<float> output_scale;     // D
};

// Between file and numbers. The reader checks every shape, range and the support pattern; on failure *data is unspecified.
WeightsResult generatorFromWeights(const WeightsFile& file, GeneratorData* data);
WeightsFile weightsFromGenerator(const GeneratorData& data);

class GeneratorScratch;

// What a function's theta is depends on the function, the weights, the precision and (float32 only) the SIMD target: not on the
// batch it stands in, its place there, the thread, or on whether its samples come as bytes or as the floats byte / 255 (int16
// only; in float32 the two differ by rounding).
class Generator {
 public:
  Generator() = default;
  explicit Generator(const GeneratorData& data, GeneratorPrecision precision = GeneratorPrecision::float32);

  // Reads a file, or its bytes, and prepares the generator; *generator is changed only on success. Obeys NLG_SIMD
  // (simd_target.h): a name that is no target of this build and machine is refused (simd_unavailable), so the first call should
  // precede other threads' work.
  static WeightsResult load(const std::string& path, GeneratorPrecision precision, Generator* generator);
  static WeightsResult load(const std::string& path, Generator* generator) {
    return load(path, GeneratorPrecision::float32, generator);
  }
  static WeightsResult parse(std::string_view bytes, GeneratorPrecision precision, Generator* generator);

  const Representation& representation() const { return representation_; }
  GeneratorPrecision precision() const { return precision_; }
  const float* theta0() const { return theta0_.data(); }

  // theta of any number of functions, in batches of kBatchCount. Any number of threads may call it at once, each with a scratch
  // of its own.
  // phi     count x P in pattern order; bytes: round(255 phi); floats: phi in [0, 1]
  // theta   count x D
  void generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const;
  void generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const;

 private:
  friend class GeneratorScratch;
  struct Width {
    int inputs, outputs;
  };
  template <class Sample>
  void generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const;
  void runLayers(int batch, float* theta, GeneratorScratch* scratch) const;

  GeneratorPrecision precision_ = GeneratorPrecision::float32;
  Representation representation_;
  float slope_ = 0.01f;
  Projection projection_;
  std::vector<Width> widths_;  // of the layers
  std::vector<PackedMatrix> float_layers_;
  std::vector<PackedIntegerMatrix> integer_layers_;
  std::vector<AlignedFloats> biases_;
  std::vector<float> theta0_;
};

// Working memory of one thread, for one generator.
class GeneratorScratch {
 public:
  explicit GeneratorScratch(const Generator& generator);

 private:
  friend class Generator;
  // rows of integers begin at cache lines, and not all in the same set of the first-level cache
  static int integerStride(int width) { return (width + 31) / 32 * 32 + 32; }

  ProjectionScratch projection_;
  AlignedFloats activations_[2];
  AlignedIntegers integers_;
  AlignedFloats scales_;
};

// theta of one function in double, straight from the formulas: what the vector code is tested against. phi: P, in [0, 1].
std::vector<double> generateReference(const GeneratorData& data, const double* phi);

}  // namespace nlg
