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

// The version of the tensors' meaning that this code writes, and the newest that it reads: 3, whose files name their digest. In
// version 2 corrections see theta in units of their own, in version 1 in those of the output.
inline constexpr int kWeightsVersion = 3;

// Learned correction steps (docs/theory/math.md §6): a network that sees a theta, how wrong it is on its function and which way is down,
// and says how theta should change. Same layers as the generator's; inputs are CorrectionFeatures (below) in their order.
struct CorrectionData {
  int step_count = 0;             // times in a row that it was trained for; 0: the generator has none
  bool exact_last_layer = false;  // the last layer is solved before every measurement (networks with a linear output)
  // How it sees theta: asinh((theta - theta0) / theta_unit), since last layers that are solved hold numbers of any size; 0, of
  // files of version 1: (theta - theta0) / output_scale.
  float theta_unit = 0.0f;
  std::vector<GeneratorLayer> layers;  // K + 2 D + 2 inputs; the last one has D outputs, times output_scale
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
  CorrectionData correction;
};

// Where the inputs of a correction lie, for K coefficients and D parameters.
struct CorrectionFeatures {
  int coefficient_count, theta_count;
  int theta() const { return coefficient_count; }                      // theta as CorrectionData::theta_unit says
  int gradient() const { return coefficient_count + theta_count; }     // sqrt(D) g / |g|, g the gradient of the mean square
  int logNorm() const { return coefficient_count + 2 * theta_count; }  // log10(|g| + 1e-12)
  int logError() const { return logNorm() + 1; }                       // log10(mean square + 1e-8)
  int count() const { return logNorm() + 2; }
};

// Between file and numbers. The reader checks every shape, range and the support pattern; on failure *data is unspecified.
FileResult generatorFromWeights(const WeightsFile& file, GeneratorData* data);
WeightsFile weightsFromGenerator(const GeneratorData& data);

class GeneratorScratch;

// What a function's theta is depends on the function, the weights, the precision and (float32 only) the SIMD target: not on the
// batch it stands in, its place there, the thread, or on whether its samples come as bytes or as the floats byte / 255 (int16
// only; in float32 the two differ by rounding).
class Generator {
 public:
  Generator() = default;
  explicit Generator(const GeneratorData& data, GeneratorPrecision precision = GeneratorPrecision::float32);

  // Reads a file, or its bytes, and prepares the generator; *generator is changed only on success. An ok result with a text is that
  // of a file without a digest. Obeys NLG_SIMD
  // (simd_target.h): a name that is no target of this build and machine is refused (simd_unavailable), so the first call should
  // precede other threads' work.
  static FileResult load(const std::string& path, GeneratorPrecision precision, Generator* generator);
  static FileResult load(const std::string& path, Generator* generator) {
    return load(path, GeneratorPrecision::float32, generator);
  }
  static FileResult parse(std::string_view bytes, GeneratorPrecision precision, Generator* generator);

  const Representation& representation() const { return representation_; }
  GeneratorPrecision precision() const { return precision_; }
  const float* theta0() const { return theta0_.data(); }

  // theta of any number of functions, in batches of kBatchCount. Any number of threads may call it at once, each with a scratch
  // of its own.
  // phi     count x P in pattern order; bytes: round(255 phi); floats: phi in [0, 1]
  // theta   count x D
  void generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const;
  void generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const;

  // The same in its two parts, for functions whose mirror images are wanted too.
  // count          at most kBatchCount
  // coefficients   count x K, divided as the basis says: what the layers read
  const Projection& projection() const { return projection_; }
  int coefficientCount() const { return projection_.coefficientCount(); }
  void project(const uint8_t* phi, int count, float* coefficients, GeneratorScratch* scratch) const;
  void generateFromCoefficients(const float* coefficients, int count, float* theta, GeneratorScratch* scratch) const;

  // Learned correction steps, for StageRunner (fit/theta_policy.h); 0 steps and no layers when the weights have none. Always float32.
  int correctionStepCount() const { return correction_step_count_; }
  bool exactLastLayer() const { return exact_last_layer_; }
  const LayerStack& correctionLayers() const { return correction_layers_; }
  // D numbers: theta as a correction sees it.
  void writeThetaFeatures(const float* theta, float* features) const;

 private:
  friend class GeneratorScratch;
  template <class Sample>
  void generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const;

  GeneratorPrecision precision_ = GeneratorPrecision::float32;
  Representation representation_;
  Projection projection_;
  LayerStack layers_;
  std::vector<float> theta0_, output_scale_;
  int correction_step_count_ = 0;
  float correction_theta_unit_ = 0.0f;
  bool exact_last_layer_ = false;
  LayerStack correction_layers_;
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

// Likewise the change of theta that a correction step proposes. features: CorrectionFeatures::count() numbers.
std::vector<double> correctionReference(const GeneratorData& data, const double* features);

}  // namespace nlg
