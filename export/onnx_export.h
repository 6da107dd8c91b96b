// Converts weights to ONNX (`nlg-export onnx`, `nlg-export --onnx FILE`).
#pragma once

#include <string>
#include <vector>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator_data.h"

namespace nlg {

// throws   UsageError when the name of a model to write does not end in .onnx
void requireOnnxName(const std::string& out);

// Writes the generator of a weights file as ONNX. Texts of the file travel along, and its SHA-256 as `weights_sha256`.
//
// data      the generator of `file`
// out       a name that requireOnnxName takes
// throws    OutputError
void writeOnnx(const WeightsFile& file, const GeneratorData& data, const std::string& sha256, const std::string& out);

// The tool's command `onnx`: nlg-export onnx --weights FILE --out FILE.
int onnxMain(int argc, char** argv);

}  // namespace nlg
