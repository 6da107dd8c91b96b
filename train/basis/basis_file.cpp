#include "train/basis/basis_file.h"

#include <algorithm>
#include <cmath>

#include "datagen/dataset/hdf5_file.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kSchemaVersion = 1;
constexpr const char* kKind = "nlg-basis";

template <class T>
void checkFinite(const std::string& path, const char* name, const std::vector<T>& values) {
  const bool finite = std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); });
  if (!finite) throw InputError(path, std::string("dataset ") + name, "finite numbers", "NaN or infinity");
}

void readClassCounts(const std::string& path, const Hdf5Reader& reader, BasisData* data) {
  const std::vector<int32_t> counts = reader.read<int32_t>("class_count", {kParityClassCount});
  for (int c = 0; c < kParityClassCount; ++c) {
    if (counts[c] < 0 || counts[c] > kOctantPointCount) {
      throw InputError(path, "dataset class_count", "0 to 1024", std::to_string(counts[c]));
    }
    data->class_count[c] = counts[c];
  }
}

}  // namespace

const OwnFiles kBasisFiles = {"a basis", [](std::string_view bytes) { return hold(bytes, kKind); }};

void writeBasisFile(const std::string& path, const BasisFile& file) {
  const BasisData& data = file.basis.data;
  const uint64_t count = static_cast<uint64_t>(data.coefficientCount());
  const std::vector<int32_t> class_count(data.class_count.begin(), data.class_count.end());
  writeAtomically(path, [&](const std::string& temporary_path) {
    Hdf5Writer writer(temporary_path);
    writer.writeAttribute("kind", std::string(kKind));
    writer.writeAttribute("schema_version", kSchemaVersion);
    writer.writeAttribute("pattern_hash", file.pattern_hash);
    writer.writeAttribute("function_count", file.basis.function_count);
    writer.writeAttribute("provenance", file.provenance_json);
    writer.write("class_count", {kParityClassCount}, class_count.data());
    writer.write("mean", {kParityClassCount, kOctantPointCount}, data.mean.data());
    writer.write("components", {count, kOctantPointCount}, data.components.data());
    writer.write("deviation", {count}, data.deviation.data());
    writer.write("spectrum", {kParityClassCount, kOctantPointCount}, file.basis.spectrum.data());
    writer.write("mean_function", {kSupportPointCount}, file.mean_function.data());
    writer.write("mean_validity", {kSupportPointCount}, file.mean_validity.data());
    writer.write("kept_counts", {file.kept_counts.size()}, file.kept_counts.data());
    writer.write("kept_variance", {file.kept_variance.size()}, file.kept_variance.data());
    writer.closeWithDigest();
  });
}

BasisFile readBasisFile(const std::string& path) {
  const Hdf5Reader reader(path);
  BasisFile file;
  BasisData& data = file.basis.data;
  // kind and version before the digest: another kind of file is no damaged basis
  if (const std::string kind = reader.readTextAttribute("kind"); kind != kKind) {
    throw InputError(path, "attribute kind", kKind, "'" + kind.substr(0, 40) + "'");
  }
  const uint64_t version = reader.readIntegerAttribute("schema_version");
  if (version != kSchemaVersion) {
    throw InputError(path, "attribute schema_version", std::to_string(kSchemaVersion) + " (fit bases of other versions again)",
                     std::to_string(version));
  }
  reader.verifyDigest();
  file.pattern_hash = reader.readIntegerAttribute("pattern_hash");
  if (file.pattern_hash != supportPattern().hash) {
    throw InputError(path, "attribute pattern_hash", std::to_string(supportPattern().hash), std::to_string(file.pattern_hash));
  }
  file.basis.function_count = reader.readIntegerAttribute("function_count");
  file.provenance_json = reader.readTextAttribute("provenance");
  readClassCounts(path, reader, &data);
  // shapes of all else follow from the components of each class
  uint64_t count = 0;
  for (const int class_count : data.class_count) count += static_cast<uint64_t>(class_count);
  data.mean = reader.read<float>("mean", {kParityClassCount, kOctantPointCount});
  data.components = reader.read<float>("components", {count, kOctantPointCount});
  data.deviation = reader.read<float>("deviation", {count});
  file.basis.spectrum = reader.read<double>("spectrum", {kParityClassCount, kOctantPointCount});
  file.mean_function = reader.read<float>("mean_function", {kSupportPointCount});
  file.mean_validity = reader.read<float>("mean_validity", {kSupportPointCount});
  file.kept_counts = reader.read<int32_t>("kept_counts", reader.shape("kept_counts"));
  file.kept_variance = reader.read<double>("kept_variance", {file.kept_counts.size()});
  // nothing that is not finite reaches a generator
  checkFinite(path, "mean", data.mean);
  checkFinite(path, "components", data.components);
  checkFinite(path, "deviation", data.deviation);
  checkFinite(path, "mean_function", file.mean_function);
  checkFinite(path, "mean_validity", file.mean_validity);
  checkFinite(path, "spectrum", file.basis.spectrum);
  checkFinite(path, "kept_variance", file.kept_variance);
  // coefficients are divided by the deviations
  const bool positive = std::all_of(data.deviation.begin(), data.deviation.end(), [](float d) { return d > 0; });
  if (!positive || data.deviation.empty())
    throw InputError(path, "dataset deviation", "positive numbers", "none, or other numbers");
  return file;
}

}  // namespace nlg
