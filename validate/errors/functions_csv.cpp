#include "validate/errors/functions_csv.h"

namespace nlg {
namespace {

// A text as a field: file stems may hold commas.
std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace

FunctionsCsv::FunctionsCsv(const FunctionSet& set, const Populations& populations) : set_(set), populations_(populations) {
  text_ << "representation,word,function,scene,take_theta,hard,blend_rmse,rmse,rmse_test_points,rmse_occluded,leak_mean,leak_p99,"
           "fails_check,"
           "fitted,elapsed_us\n";
}

void FunctionsCsv::add(const std::string& representation, const MeasuredWord& word) {
  for (const MeasuredFunction& one : word.functions) {
    const FunctionError& error = one.error;
    text_ << representation << ',' << word.name << ',' << one.function << ','
          << csvField(set_.scene_ids[set_.scene_idx[one.function]]) << ',' << populations_.takesTheta(one.function) << ','
          << populations_.isHard(one.function) << ',' << error.blend_rmse << ',' << error.rmse << ',' << error.rmse_test_points
          << ',';
    if (error.has_occluded) text_ << error.rmse_occluded;
    text_ << ',' << error.leak_mean << ',' << error.leak_p99 << ',' << one.fails_check << ',' << one.fitted << ','
          << one.elapsed_us << '\n';
  }
}

}  // namespace nlg
