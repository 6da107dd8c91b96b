#include "runtime_eval/light_grid/light_grid_file.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <memory>
#include <system_error>
#include <utility>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/probe_tree_data.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {
namespace {

constexpr const char* kKind = "nlg-light-grid";
constexpr const char* kVersion = "1";
constexpr std::string_view kRepresentationPrefix = "representation.", kSlopePrefix = "slope.", kDictionaryPrefix = "dictionary.";
constexpr const char *kNodesSuffix = ".nodes", *kExponentsSuffix = ".exponents";

std::string numbered(std::string_view prefix, size_t index) { return std::string(prefix) + std::to_string(index); }

std::string patternHash() {
  char text[16];
  const auto end = std::to_chars(text, text + sizeof text, supportPattern().hash, 16).ptr;
  const std::string digits(text, end);
  return std::string(sizeof text - digits.size(), '0') + digits;
}

// The shortest text that reads as the same number.
std::string slopeText(float slope) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, slope).ptr};
}

bool isOwnKey(std::string_view key) {
  for (const std::string_view own : {"kind", "version", "pattern_hash", "light", "representation_count", kDigestKey})
    if (key == own) return true;
  return key.substr(0, kRepresentationPrefix.size()) == kRepresentationPrefix ||
         key.substr(0, kSlopePrefix.size()) == kSlopePrefix;
}

// The file's own keys beside the caller's.
FileResult addOwnMetadata(const LightGrid& grid, LightForm light, GridMetadata* metadata) {
  for (const auto& [key, text] : *metadata) {
    if (isOwnKey(key)) return refuse(FileStatus::value_out_of_range, "metadata " + key + ": a key of the file's own");
  }
  (*metadata)["kind"] = kKind;
  (*metadata)["version"] = kVersion;
  (*metadata)["pattern_hash"] = patternHash();
  (*metadata)["light"] = lightFormName(light);
  (*metadata)["representation_count"] = std::to_string(grid.representations.size());
  for (size_t i = 0; i < grid.representations.size(); ++i) {
    const Representation& representation = grid.representations[i];
    (*metadata)[numbered(kRepresentationPrefix, i)] = representationName(representation);
    if (representation.isNetwork()) (*metadata)[numbered(kSlopePrefix, i)] = slopeText(representation.slope);
  }
  return {};
}

// Numbers of the longest code that each representation's functions have, once they are rounded.
std::vector<int> longestCodes(const LightGrid& grid, ThetaPrecision precision) {
  std::vector<int> longest(grid.representations.size(), 0);
  for (size_t function = 0; function < grid.functionCount(); ++function) {
    const uint8_t r = grid.function_representation[function];
    const Representation& representation = grid.representations[r];
    if (!representation.isCode()) continue;
    Theta theta(grid.functionTheta(function), grid.functionTheta(function) + representation.thetaCount());
    roundTheta(representation, precision, theta.data());
    longest[r] = std::max(longest[r], codeLength(representation.thetaCount(), theta.data()));
  }
  return longest;
}

// A dictionary as a file has it: rows of the longest code, then c.
struct StoredDictionary {
  std::vector<int8_t> nodes, exponents;
};

StoredDictionary storedDictionary(const DictionaryData& data, int longest) {
  const auto nodes = data.nodes.size() / data.exponents.size();
  StoredDictionary stored{{data.nodes.begin(), data.nodes.begin() + static_cast<ptrdiff_t>(nodes) * longest},
                          {data.exponents.begin(), data.exponents.begin() + longest}};
  stored.nodes.insert(stored.nodes.end(), data.nodes.end() - static_cast<ptrdiff_t>(nodes), data.nodes.end());
  stored.exponents.push_back(data.exponents.back());
  return stored;
}

// The nearest numbers in bytes; of codes without the zeros that they end on.
FileResult stepsOf(const LightGrid& grid, PackedTheta* packed) {
  Theta theta;
  for (size_t function = 0; function < grid.functionCount(); ++function) {
    const Representation& representation = grid.representations[grid.function_representation[function]];
    theta.assign(grid.functionTheta(function), grid.functionTheta(function) + representation.thetaCount());
    if (!roundTheta(representation, ThetaPrecision::int8, theta.data())) {
      return refuse(FileStatus::value_out_of_range,
                    "function " + std::to_string(function) + ": its last layer is beyond float16 when the others are in int8");
    }
    packTheta(representation, theta.data(), packed);
  }
  return {};
}

FileResult halvesOf(const LightGrid& grid, std::vector<Half>* halves) {
  halves->resize(grid.theta.size());
  for (size_t i = 0; i < grid.theta.size(); ++i) {
    if (halfFromFloat(grid.theta[i], &(*halves)[i])) continue;
    const auto next = std::upper_bound(grid.theta_begin.begin(), grid.theta_begin.end(), i);
    const auto function = static_cast<size_t>(next - grid.theta_begin.begin() - 1);
    return refuse(FileStatus::value_out_of_range, "function " + std::to_string(function) + ": theta " +
                                                      std::to_string(i - grid.theta_begin[function]) + " is " +
                                                      std::to_string(grid.theta[i]) + "; float16 holds up to 65504");
  }
  return {};
}

// Of probes whose light some look-up reads: those with weight, in their order.
size_t countWithWeight(const LightGrid& grid) {
  return grid.probe_function.size() -
         static_cast<size_t>(std::count(grid.probe_function.begin(), grid.probe_function.end(), kNoWeight));
}

LightForm formOf(const LightGrid& grid, const GridPrecision& precision) {
  return grid.light.empty() ? LightForm::none : precision.light;
}

FileResult packedLight(const LightGrid& grid, LightForm form, PackedLight* packed) {
  std::vector<float> light;
  for (size_t probe = 0; probe < grid.probe_function.size() && form != LightForm::none; ++probe) {
    if (grid.probe_function[probe] != kNoWeight)
      light.insert(light.end(), grid.probeLight(probe), grid.probeLight(probe) + kShFloats);
  }
  FileResult result = packLight(form, light, packed);
  // a form may make more of the largest numbers than a reader takes
  if (result.ok()) result = unpackLight(form, *packed, light.size() / kShFloats, &light);
  if (result.ok()) result = checkLight(light);
  return result;
}

void takeFirst(FileResult* result, FileResult next) {
  if (result->ok()) *result = std::move(next);
}

FileResult refuseCount(const std::string& tensor, size_t expected, size_t got) {
  return refuse(FileStatus::tensor_unexpected,
                tensor + ": expected " + std::to_string(expected) + " values, got " + std::to_string(got));
}

// A tensor of exactly kCount numbers.
template <size_t kCount, class T>
FileResult readNumbers(const TensorFileReader& reader, const std::string& name, T* numbers) {
  std::vector<T> values;
  FileResult result = reader.read(name, &values);
  if (!result.ok()) return result;
  if (values.size() != kCount) return refuseCount(name, kCount, values.size());
  std::copy(values.begin(), values.end(), numbers);
  return {};
}

FileResult readFrame(const TensorFileReader& reader, ProbeTreeFrame* frame) {
  FileResult result = readNumbers<3>(reader, "frame.first_m", frame->first_m.data());
  takeFirst(&result, readNumbers<1>(reader, "frame.spacing_m", &frame->spacing_m));
  takeFirst(&result, readNumbers<3>(reader, "frame.root_count", frame->root_count.data()));
  return result;
}

FileResult refuseTree(const std::string& fault) {
  return fault.empty() ? FileResult{} : refuse(FileStatus::value_out_of_range, "probe tree: " + fault);
}

// After probe_function, which says how many probes there are.
FileResult readTree(const TensorFileReader& reader, LightGrid* grid) {
  ProbeTreeData data;
  PackedNodes nodes;
  FileResult result = readFrame(reader, &data.frame);
  takeFirst(&result, reader.read("node.kind", &nodes.kind));
  takeFirst(&result, reader.read("node.bits", &nodes.bits));
  if (result.ok()) result = refuseTree(unpackNodes(nodes, &data));
  if (result.ok()) result = refuseTree(makeProbeTree(data, grid->probe_function.size(), &grid->tree));
  return result;
}

template <class T>
bool parseNumber(const std::string& text, T* number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  return error == std::errc() && end == text.data() + text.size();
}

// Takes one of the file's own keys out of the metadata.
FileResult takeText(GridMetadata* metadata, const std::string& key, std::string* text) {
  const auto found = metadata->find(key);
  if (found == metadata->end()) return refuse(FileStatus::tensor_missing, "no metadata key " + key);
  *text = std::move(found->second);
  metadata->erase(found);
  return {};
}

FileResult refuseText(FileStatus status, const std::string& key, const std::string& expected, const std::string& got) {
  return refuse(status,
                "metadata " + key + ": expected " + expected + ", got " + jsonQuoted(std::string_view(got).substr(0, 40)));
}

FileResult takeIdentity(GridMetadata* metadata) {
  std::string kind, version, pattern;
  FileResult result = takeText(metadata, "kind", &kind);
  takeFirst(&result, takeText(metadata, "version", &version));
  takeFirst(&result, takeText(metadata, "pattern_hash", &pattern));
  if (!result.ok()) return result;
  if (kind != kKind) return refuseText(FileStatus::value_out_of_range, "kind", kKind, kind);
  if (version != kVersion) return refuseText(FileStatus::version_unknown, "version", kVersion, version);
  if (pattern != patternHash()) return refuseText(FileStatus::pattern_unknown, "pattern_hash", patternHash(), pattern);
  return {};
}

FileResult takeRepresentations(GridMetadata* metadata, std::vector<Representation>* representations) {
  std::string text;
  FileResult result = takeText(metadata, "representation_count", &text);
  if (!result.ok()) return result;
  size_t count = 0;
  if (!parseNumber(text, &count) || count > kMaxGridRepresentations)
    return refuseText(FileStatus::value_out_of_range, "representation_count", "0 to 256", text);
  for (size_t i = 0; i < count; ++i) {
    Representation representation;
    const std::string key = numbered(kRepresentationPrefix, i), slope_key = numbered(kSlopePrefix, i);
    result = takeText(metadata, key, &text);
    if (!result.ok()) return result;
    if (!findRepresentation(text, &representation))
      return refuseText(FileStatus::value_out_of_range, key, representationNames(), text);
    if (representation.isNetwork()) {
      result = takeText(metadata, slope_key, &text);
      if (!result.ok()) return result;
      if (!parseNumber(text, &representation.slope))
        return refuseText(FileStatus::value_out_of_range, slope_key, "a number in (0, 1)", text);
    }
    representations->push_back(representation);
  }
  return {};
}

// Functions of probes in two bytes: for grids of at most kMaxShortFunctions.
constexpr size_t kMaxShortFunctions = 0xfffe;

uint16_t shortFunction(uint32_t function) {
  return function == kFreeSpace ? 0xffff : function == kNoWeight ? 0xfffe : static_cast<uint16_t>(function);
}
uint32_t longFunction(uint16_t function) { return function == 0xffff ? kFreeSpace : function == 0xfffe ? kNoWeight : function; }

FileResult readProbeFunctions(const TensorFileReader& reader, bool is_short, std::vector<uint32_t>* probe_function) {
  if (!is_short) return reader.read("probe.function", probe_function);
  std::vector<uint16_t> functions;
  FileResult result = reader.read("probe.function", &functions);
  std::transform(functions.begin(), functions.end(), std::back_inserter(*probe_function), longFunction);
  return result;
}

// After the functions' representations.
FileResult readSteps(const TensorFileReader& reader, LightGrid* grid) {
  PackedTheta packed;
  FileResult result = reader.read("theta.steps", &packed.steps);
  takeFirst(&result, reader.read("theta.halves", &packed.halves));
  if (!reader.dtypeOf("theta.groups").empty()) takeFirst(&result, reader.read("theta.groups", &packed.groups));
  if (!result.ok()) return result;
  // functions whose representation does not exist are for checkLightGrid to name
  const auto representationOf = [&](uint8_t r) { return r < grid->representations.size() ? &grid->representations[r] : nullptr; };
  size_t code_count = 0;
  for (const uint8_t r : grid->function_representation)
    code_count += representationOf(r) != nullptr && representationOf(r)->isCode();
  if (packed.groups.size() != code_count) return refuseCount("theta.groups", code_count, packed.groups.size());
  size_t step_count = 0, half_count = 0, theta_count = 0, code = 0;
  std::vector<int> steps_of_function;
  for (const uint8_t r : grid->function_representation) {
    const Representation* of = representationOf(r);
    if (of == nullptr) continue;
    const ThetaForm form = thetaForm(*of, ThetaPrecision::int8);
    const int steps = of->isCode() ? kCodeGroup * (packed.groups[code++] % kCodeExponentUnit) : form.steps;
    if (steps > form.steps) {
      return refuse(FileStatus::value_out_of_range, "theta.groups: value " + std::to_string(code - 1) + ": expected at most " +
                                                        std::to_string(form.steps / kCodeGroup));
    }
    steps_of_function.push_back(steps);
    step_count += steps, half_count += form.halves, theta_count += of->thetaCount();
  }
  if (packed.steps.size() != step_count) return refuseCount("theta.steps", step_count, packed.steps.size());
  if (packed.halves.size() != half_count) return refuseCount("theta.halves", half_count, packed.halves.size());
  const auto beyond = std::find(packed.steps.begin(), packed.steps.end(), int8_t{-128});
  if (beyond != packed.steps.end()) {
    return refuse(FileStatus::value_out_of_range,
                  "theta.steps: value " + std::to_string(beyond - packed.steps.begin()) + ": expected -127 to 127");
  }
  grid->theta.resize(theta_count);
  const int8_t* steps = packed.steps.data();
  const Half* halves = packed.halves.data();
  float* theta = grid->theta.data();
  size_t function = 0;
  code = 0;
  for (const uint8_t r : grid->function_representation) {
    const Representation* of = representationOf(r);
    if (of == nullptr) continue;
    const int count = steps_of_function[function++];
    if (of->isCode()) {
      if (!unpackCode(of->thetaCount(), packed.groups[code++], steps, theta)) {
        return refuse(FileStatus::value_out_of_range,
                      "theta.groups: expected no group of zeros at the end of a code, and no coarser steps than it needs");
      }
    } else {
      unpackTheta(*of, steps, halves, theta);
    }
    steps += count, halves += thetaForm(*of, ThetaPrecision::int8).halves, theta += of->thetaCount();
  }
  return {};
}

FileResult readFunctions(const TensorFileReader& reader, LightGrid* grid) {
  FileResult result = reader.read("function.representation", &grid->function_representation);
  takeFirst(&result, readProbeFunctions(reader, grid->functionCount() <= kMaxShortFunctions, &grid->probe_function));
  if (!result.ok()) return result;
  for (const uint8_t representation : grid->function_representation) {
    // those that do not exist are for checkLightGrid to name
    const int count = representation < grid->representations.size() ? grid->representations[representation].thetaCount() : 0;
    grid->theta_begin.push_back(grid->theta_begin.back() + static_cast<uint64_t>(count));
  }
  if (!reader.dtypeOf("theta.steps").empty()) return readSteps(reader, grid);
  if (reader.dtypeOf("theta") != tensorDtype<Half>()) return reader.read("theta", &grid->theta);
  std::vector<Half> halves;
  result = reader.read("theta", &halves);
  if (!result.ok()) return result;
  grid->theta.resize(halves.size());
  std::transform(halves.begin(), halves.end(), grid->theta.begin(), floatFromHalf);
  return {};
}

// Of one representation that is a code. After theta: a file holds as many rows as the longest code needs.
FileResult readDictionary(const TensorFileReader& reader, const std::string& name, int longest, Representation* code) {
  StoredDictionary stored;
  FileResult result = reader.read(name + kNodesSuffix, &stored.nodes);
  takeFirst(&result, reader.read(name + kExponentsSuffix, &stored.exponents));
  if (!result.ok()) return result;
  const auto rows = static_cast<size_t>(longest) + 1;
  if (stored.exponents.size() != rows) return refuseCount(name + kExponentsSuffix, rows, stored.exponents.size());
  DictionaryData data;
  data.code_count = code->code_count;
  const auto nodesOf = [](int r) { return static_cast<size_t>(r) * r * r; };
  while (data.resolution < kMaxBrickResolution && rows * nodesOf(data.resolution) < stored.nodes.size()) ++data.resolution;
  const size_t nodes = nodesOf(data.resolution);
  if (stored.nodes.size() != rows * nodes) return refuseCount(name + kNodesSuffix, rows * nodes, stored.nodes.size());
  const auto last = stored.nodes.end() - static_cast<ptrdiff_t>(nodes);
  data.nodes.assign(stored.nodes.begin(), last);
  data.nodes.resize(nodes * static_cast<size_t>(data.code_count), 0);
  data.nodes.insert(data.nodes.end(), last, stored.nodes.end());
  data.exponents.assign(stored.exponents.begin(), stored.exponents.end() - 1);
  data.exponents.resize(static_cast<size_t>(data.code_count) + 1, stored.exponents.back());
  data.deviations.assign(static_cast<size_t>(data.code_count), 1.0f);
  const std::string fault = whatIsWrong(data);
  if (!fault.empty()) return refuse(FileStatus::value_out_of_range, name + ": " + fault);
  *code = Representation::code(std::make_shared<const Dictionary>(std::move(data)));
  return {};
}

FileResult readDictionaries(const TensorFileReader& reader, LightGrid* grid) {
  std::vector<int> longest(grid->representations.size(), 0);
  for (size_t function = 0; function < grid->functionCount(); ++function) {
    const uint8_t r = grid->function_representation[function];
    // what does not fit together is for checkLightGrid to name
    if (r >= longest.size() || grid->theta_begin[function + 1] > grid->theta.size()) return {};
    const Representation& of = grid->representations[r];
    if (of.isCode()) longest[r] = std::max(longest[r], codeLength(of.code_count, grid->functionTheta(function)));
  }
  FileResult result;
  for (size_t r = 0; r < longest.size() && result.ok(); ++r) {
    if (grid->representations[r].isCode())
      result = readDictionary(reader, numbered(kDictionaryPrefix, r), longest[r], &grid->representations[r]);
  }
  return result;
}

FileResult takeLightForm(GridMetadata* metadata, LightForm* form) {
  std::string text;
  FileResult result = takeText(metadata, "light", &text);
  if (!result.ok() || findLightForm(text, form)) return result;
  return refuseText(FileStatus::value_out_of_range, "light", "none, sh2_float16, sh2_8bit, zh3_float16 or sh1_float16", text);
}

// After the functions of probes, which say whose light there is.
FileResult readLight(const TensorFileReader& reader, LightForm form, LightGrid* grid) {
  if (form == LightForm::none) return {};
  PackedLight packed;
  std::vector<float> light;
  FileResult result = readNumbers<1>(reader, "light.scale", &packed.scale);
  takeFirst(&result, reader.read("light.halves", &packed.halves));
  if (form == LightForm::sh2_8bit) takeFirst(&result, reader.read("light.steps", &packed.steps));
  if (result.ok()) result = unpackLight(form, packed, countWithWeight(*grid), &light);
  if (!result.ok()) return result;
  grid->light.resize(grid->probe_function.size() * kShFloats);
  auto next = light.begin();
  for (size_t probe = 0; probe < grid->probe_function.size(); ++probe) {
    if (grid->probe_function[probe] == kNoWeight) continue;
    std::copy_n(next, kShFloats, grid->light.begin() + static_cast<ptrdiff_t>(probe * kShFloats));
    next += kShFloats;
  }
  return {};
}

FileResult readGrid(const TensorFileReader& reader, LightGrid* grid, GridMetadata* metadata) {
  *metadata = reader.metadata();
  LightForm form = LightForm::none;
  FileResult result = takeIdentity(metadata);
  if (result.ok() && !reader.hasDigest()) result = refuse(FileStatus::digest_mismatch, kDigestMissing);
  if (result.ok()) result = takeLightForm(metadata, &form);
  if (result.ok()) result = takeRepresentations(metadata, &grid->representations);
  if (!result.ok()) return result;
  for (const auto& [key, text] : *metadata) {
    if (isOwnKey(key)) return refuse(FileStatus::value_out_of_range, "metadata " + key + ": expected no such key");
  }
  result = readFunctions(reader, grid);
  if (result.ok()) result = readDictionaries(reader, grid);
  if (result.ok()) result = readTree(reader, grid);
  if (result.ok()) result = readLight(reader, form, grid);
  if (result.ok()) result = checkWithoutBricks(*grid);
  if (result.ok()) grid->makeBricks();
  return result;
}

// Nothing half-read reaches the caller.
FileResult finish(const FileResult& opened, const TensorFileReader& reader, LightGrid* grid, GridMetadata* metadata) {
  *grid = {};
  metadata->clear();
  if (!opened.ok()) return opened;
  LightGrid read_grid;
  GridMetadata read_metadata;
  FileResult result = readGrid(reader, &read_grid, &read_metadata);
  if (!result.ok()) return result;
  *grid = std::move(read_grid);
  *metadata = std::move(read_metadata);
  return opened;
}

}  // namespace

FileResult serializeLightGrid(const LightGrid& grid, const GridPrecision& precision, const GridMetadata& metadata,
                              std::string* bytes) {
  bytes->clear();
  FileResult result = checkLightGrid(grid);
  GridMetadata texts = metadata;
  const LightForm form = formOf(grid, precision);
  const bool in_steps = precision.theta == ThetaPrecision::int8;
  takeFirst(&result, addOwnMetadata(grid, form, &texts));
  PackedLight light;
  if (result.ok()) result = packedLight(grid, form, &light);
  const std::vector<float> light_scale{light.scale};
  std::vector<Half> halves;
  PackedTheta packed;
  if (result.ok() && precision.theta == ThetaPrecision::float16) result = halvesOf(grid, &halves);
  if (result.ok() && in_steps) result = stepsOf(grid, &packed);
  if (!result.ok()) return result;
  std::vector<StoredDictionary> dictionaries(grid.representations.size());
  const std::vector<int> longest = longestCodes(grid, precision.theta);

  const ProbeTreeData tree = probeTreeData(grid.tree);
  const PackedNodes nodes = packNodes(tree);
  const std::vector<double> first_m(tree.frame.first_m.begin(), tree.frame.first_m.end()), spacing_m{tree.frame.spacing_m};
  const std::vector<int32_t> root_count(tree.frame.root_count.begin(), tree.frame.root_count.end());
  const bool is_short = grid.functionCount() <= kMaxShortFunctions;
  std::vector<uint16_t> short_functions;
  if (is_short) {
    std::transform(grid.probe_function.begin(), grid.probe_function.end(), std::back_inserter(short_functions), shortFunction);
  }
  TensorFileWriter writer;
  writer.add("frame.first_m", first_m);
  writer.add("frame.spacing_m", spacing_m);
  writer.add("frame.root_count", root_count);
  writer.add("node.kind", nodes.kind);
  writer.add("node.bits", nodes.bits);
  if (is_short) {
    writer.add("probe.function", short_functions);
  } else {
    writer.add("probe.function", grid.probe_function);
  }
  writer.add("function.representation", grid.function_representation);
  if (in_steps) {
    writer.add("theta.steps", packed.steps);
    writer.add("theta.halves", packed.halves);
    if (!packed.groups.empty()) writer.add("theta.groups", packed.groups);
  } else if (precision.theta == ThetaPrecision::float16) {
    writer.add("theta", halves);
  } else {
    writer.add("theta", grid.theta);
  }
  for (size_t r = 0; r < grid.representations.size(); ++r) {
    if (!grid.representations[r].isCode()) continue;
    dictionaries[r] = storedDictionary(grid.representations[r].dictionary->data(), longest[r]);
    writer.add(numbered(kDictionaryPrefix, r) + kNodesSuffix, dictionaries[r].nodes);
    writer.add(numbered(kDictionaryPrefix, r) + kExponentsSuffix, dictionaries[r].exponents);
  }
  if (form != LightForm::none) {
    writer.add("light.scale", light_scale);
    writer.add("light.halves", light.halves);
  }
  if (form == LightForm::sh2_8bit) writer.add("light.steps", light.steps);
  return writer.serialize(texts, bytes);
}

FileResult readLightGridFile(const std::string& path, LightGrid* grid, GridMetadata* metadata) {
  TensorFileReader reader;
  const FileResult opened = reader.openFile(path);
  FileResult result = finish(opened, reader, grid, metadata);
  if (!result.detail.empty()) result.detail = path + ": " + result.detail;
  return result;
}

FileResult parseLightGrid(std::string_view bytes, LightGrid* grid, GridMetadata* metadata) {
  TensorFileReader reader;
  const FileResult opened = reader.openBytes(bytes);
  return finish(opened, reader, grid, metadata);
}

LightGridBytes lightGridBytes(const LightGrid& grid, const GridPrecision& precision) {
  const LightForm form = formOf(grid, precision);
  const PackedNodes nodes = packNodes(probeTreeData(grid.tree));
  size_t theta_bytes = 0;
  for (size_t f = 0; f < grid.functionCount(); ++f)
    theta_bytes +=
        storedThetaBytes(grid.representations[grid.function_representation[f]], precision.theta, grid.functionTheta(f));
  size_t dictionary_bytes = 0;
  const std::vector<int> longest = longestCodes(grid, precision.theta);
  for (size_t r = 0; r < grid.representations.size(); ++r) {
    if (!grid.representations[r].isCode()) continue;
    const StoredDictionary stored = storedDictionary(grid.representations[r].dictionary->data(), longest[r]);
    dictionary_bytes += stored.nodes.size() + stored.exponents.size();
  }
  constexpr size_t kFrameBytes = sizeof(PositionM) + sizeof(double) + 3 * sizeof(int32_t);
  return {.light = form == LightForm::none ? 0 : sizeof(float) + countWithWeight(grid) * lightFormBytes(form),
          .theta = theta_bytes,
          .dictionaries = dictionary_bytes,
          .functions = grid.function_representation.size() * sizeof(uint8_t),
          .probe_function =
              grid.probe_function.size() * (grid.functionCount() <= kMaxShortFunctions ? sizeof(uint16_t) : sizeof(uint32_t)),
          .tree = kFrameBytes + nodes.kind.size() + nodes.bits.size()};
}

}  // namespace nlg
