// Writes an exported generator as ONNX, opset 17, IR version 8, for programs with their own runtime.
//
// docs/reference/formats.md lists inputs, outputs and texts. A matrix whose values are all float16's own is stored as float16 and widened in
// the graph: a model of float16 weights is as small as they are, and not less exact.
#pragma once

#include <map>
#include <string>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"

namespace nlg {

// The generator from samples to theta, N functions at a time (N is free).
//
// inputs    `phi` N x 8192, float in [0, 1], pattern order; of samples `phi` and `valid` N x 1024, by sample point
// outputs   `theta` N x D; `coefficients` N x K, divided as the basis says
// metadata  texts that travel with the model
// returns   the file's bytes; the same arguments give the same bytes
// throws    std::runtime_error when ONNX's own checker refuses the model: a bug of ours
std::string onnxFromGenerator(const GeneratorData& data, const std::map<std::string, std::string>& metadata);

}  // namespace nlg
