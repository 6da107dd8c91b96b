#include "runtime_eval/light_grid/light_grid_file.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <memory>
#include <system_error>
#include <utility>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/light_records.h"
#include "runtime_eval/light_grid/probe_tree_data.h"
#include "runtime_eval/numbers/coded_bytes.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {
namespace {

constexpr const char* kKind = "nlg-light-grid";
constexpr const char* kVersion = "2";
constexpr const char* kPackedLight = "axes";
constexpr const char* kNoLight = "none";
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
  for (const std::string_view own :
       {"kind", "version", "pattern_hash", "light", "light_groups", "light_groups_dark", "representation_count", kDigestKey})
    if (key == own) return true;
  return key.substr(0, kRepresentationPrefix.size()) == kRepresentationPrefix ||
         key.substr(0, kSlopePrefix.size()) == kSlopePrefix;
}

// Names of all groups, or of those that begin dark, a line each.
std::string groupsText(const LightGrid& grid, bool dark_alone) {
  std::string text;
  for (const LightGroup& group : grid.groups) {
    if (group.begins_dark || !dark_alone) text += (text.empty() ? "" : "\n") + group.name;
  }
  return text;
}

// The file's own keys beside the caller's.
FileResult addOwnMetadata(const LightGrid& grid, bool has_light, GridMetadata* metadata) {
  for (const auto& [key, text] : *metadata) {
    if (isOwnKey(key)) return refuse(FileStatus::value_out_of_range, "metadata " + key + ": a key of the file's own");
  }
  (*metadata)["kind"] = kKind;
  (*metadata)["version"] = kVersion;
  (*metadata)["pattern_hash"] = patternHash();
  (*metadata)["light"] = has_light ? kPackedLight : kNoLight;
  if (has_light && !grid.groups.empty()) (*metadata)["light_groups"] = groupsText(grid, false);
  if (const std::string dark = groupsText(grid, true); has_light && !dark.empty()) (*metadata)["light_groups_dark"] = dark;
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

bool hasLight(const LightGrid& grid, const GridPrecision& precision) {
  return !grid.light.empty() && precision.light_error.has_value();
}

size_t bytesOf(const PackedLight& light, const LightGrid& grid) {
  constexpr size_t kAxisBytes = sizeof(uint8_t) + sizeof(int32_t) + kShFloats * sizeof(Half);
  return sizeof(float) + sizeof(uint8_t) + light.axes.size() * kAxisBytes +
         codedRecords(light, recordsBefore(grid.tree, grid.probe_function)).size();
}

// Rounding may make more of the largest numbers than a reader takes.
FileResult checkPackedLight(const LightGrid& grid, const PackedLight& packed) {
  std::vector<std::vector<float>> light;
  FileResult result = unpackGridLight(packed, grid.probe_function, std::max<size_t>(1, grid.groups.size()), &light);
  for (const std::vector<float>& of_group : light) {
    if (result.ok()) result = checkLight(of_group);
  }
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

// A tensor of bytes that codedBytes made.
FileResult readCoded(const TensorFileReader& reader, const std::string& name, const std::vector<uint16_t>& columns,
                     std::vector<uint8_t>* bytes) {
  std::vector<uint8_t> coded;
  FileResult result = reader.read(name, &coded);
  if (!result.ok() || decodeBytes(coded, columns, bytes)) return result;
  return refuse(FileStatus::tensor_unexpected,
                name + ": not the code of " + (columns.empty() ? std::string("any") : std::to_string(columns.size())) + " bytes");
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
  takeFirst(&result, readCoded(reader, "node.kind", {}, &nodes.kind));
  takeFirst(&result, readCoded(reader, "node.bits", {}, &nodes.bits));
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
  if (version != kVersion) {
    return refuseText(FileStatus::version_unknown, "version",
                      std::string(kVersion) + " (grids of earlier versions are to be baked again)", version);
  }
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

// What a probe has, in two bits. Most have a bare tent, and functions are numbered in the order of the probes that have them first.
enum ProbeKind : uint32_t { kTentProbe, kNoWeightProbe, kNextFunction, kNamedFunction };
constexpr size_t kProbesAByte = 4;

struct StoredProbes {
  std::vector<uint8_t> kinds;
  std::vector<uint32_t> names;  // of those that are not the next
};

StoredProbes storedProbes(const std::vector<uint32_t>& probe_function) {
  StoredProbes stored;
  stored.kinds.resize((probe_function.size() + kProbesAByte - 1) / kProbesAByte);
  uint32_t next = 0;
  for (size_t probe = 0; probe < probe_function.size(); ++probe) {
    const uint32_t function = probe_function[probe];
    const ProbeKind kind = function == kFreeSpace  ? kTentProbe
                           : function == kNoWeight ? kNoWeightProbe
                           : function == next      ? kNextFunction
                                                   : kNamedFunction;
    next += kind == kNextFunction;
    if (kind == kNamedFunction) stored.names.push_back(function);
    stored.kinds[probe / kProbesAByte] |= static_cast<uint8_t>(kind << 2 * (probe % kProbesAByte));
  }
  return stored;
}

// Four bytes a name, each in a column of its own.
std::vector<uint8_t> bytesOfNames(const std::vector<uint32_t>& names) {
  std::vector<uint8_t> bytes;
  for (const uint32_t name : names) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<uint8_t>(name >> 8 * i));
  }
  return bytes;
}

std::vector<uint16_t> columnsOfNames(size_t count) {
  std::vector<uint16_t> columns(4 * count);
  for (size_t i = 0; i < columns.size(); ++i) columns[i] = static_cast<uint16_t>(i % 4);
  return columns;
}

FileResult readProbeFunctions(const TensorFileReader& reader, std::vector<uint32_t>* probe_function) {
  uint32_t count = 0;
  std::vector<uint8_t> kinds, names;
  FileResult result = readNumbers<1>(reader, "probe.count", &count);
  takeFirst(&result, readCoded(reader, "probe.kind", {}, &kinds));
  if (!result.ok()) return result;
  const size_t bytes = (size_t{count} + kProbesAByte - 1) / kProbesAByte;
  if (kinds.size() != bytes) return refuseCount("probe.kind", bytes, kinds.size());
  const auto kindOf = [&](size_t probe) { return kinds[probe / kProbesAByte] >> 2 * (probe % kProbesAByte) & 3; };
  size_t named = 0;
  for (size_t probe = 0; probe < count; ++probe) named += kindOf(probe) == kNamedFunction;
  result = readCoded(reader, "probe.function", columnsOfNames(named), &names);
  if (!result.ok()) return result;
  uint32_t next = 0;
  const uint8_t* name = names.data();
  for (size_t probe = 0; probe < count; ++probe) {
    const uint32_t kind = kindOf(probe);
    uint32_t function = kind == kTentProbe ? kFreeSpace : kNoWeight;
    if (kind == kNextFunction) function = next++;
    if (kind == kNamedFunction) {
      function = uint32_t{name[0]} | uint32_t{name[1]} << 8 | uint32_t{name[2]} << 16 | uint32_t{name[3]} << 24;
      // that it exists is checked with the grid
      if (function >= kNoWeight)
        return refuse(FileStatus::value_out_of_range, "probe.function: value " + std::to_string((name - names.data()) / 4));
      name += 4;
    }
    probe_function->push_back(function);
  }
  return {};
}

// What numbers of theta have the same meaning, for codedBytes: those of one place in one representation, of halves each byte by itself.
// Numbers of product fields are pairs at each node, which are all alike.
struct ThetaColumns {
  std::vector<uint16_t> steps, halves;
};

// steps_of_function   as many as functions of representations that exist
ThetaColumns thetaColumns(const LightGrid& grid, const std::vector<int>& steps_of_function) {
  constexpr int kBytesOfPair = 2 * sizeof(Half);
  std::vector<int> first_step(grid.representations.size(), -1), first_half = first_step;
  int next_step = 0, next_half = 0;
  ThetaColumns columns;
  size_t function = 0;
  for (const uint8_t r : grid.function_representation) {
    if (r >= grid.representations.size()) continue;
    const ThetaForm form = thetaForm(grid.representations[r], ThetaPrecision::int8);
    const int half_bytes = static_cast<int>(sizeof(Half)) * form.halves;
    const int half_columns = grid.representations[r].isNetwork() ? half_bytes : kBytesOfPair;
    if (first_step[r] < 0) {
      first_step[r] = next_step, next_step += form.steps;
      first_half[r] = next_half, next_half += half_columns;
    }
    for (int i = 0; i < steps_of_function[function]; ++i) columns.steps.push_back(static_cast<uint16_t>(first_step[r] + i));
    for (int i = 0; i < half_bytes; ++i) columns.halves.push_back(static_cast<uint16_t>(first_half[r] + i % half_columns));
    ++function;
  }
  return columns;
}

// After the functions' representations.
FileResult readSteps(const TensorFileReader& reader, LightGrid* grid) {
  PackedTheta packed;
  FileResult result;
  if (!reader.dtypeOf("theta.groups").empty()) result = readCoded(reader, "theta.groups", {}, &packed.groups);
  if (!result.ok()) return result;
  // functions whose representation does not exist are for checkLightGrid to name
  const auto representationOf = [&](uint8_t r) { return r < grid->representations.size() ? &grid->representations[r] : nullptr; };
  size_t code_count = 0;
  for (const uint8_t r : grid->function_representation)
    code_count += representationOf(r) != nullptr && representationOf(r)->isCode();
  if (packed.groups.size() != code_count) return refuseCount("theta.groups", code_count, packed.groups.size());
  size_t theta_count = 0, code = 0;
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
    theta_count += of->thetaCount();
  }
  const ThetaColumns columns = thetaColumns(*grid, steps_of_function);
  std::vector<uint8_t> step_bytes, half_bytes;
  result = readCoded(reader, "theta.steps", columns.steps, &step_bytes);
  takeFirst(&result, readCoded(reader, "theta.halves", columns.halves, &half_bytes));
  if (!result.ok()) return result;
  packed.steps.assign(step_bytes.begin(), step_bytes.end());
  for (size_t i = 0; i < half_bytes.size(); i += sizeof(Half))
    packed.halves.push_back({static_cast<uint16_t>(half_bytes[i] | half_bytes[i + 1] << 8)});
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
  FileResult result = readCoded(reader, "function.representation", {}, &grid->function_representation);
  takeFirst(&result, readProbeFunctions(reader, &grid->probe_function));
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

FileResult takeHasLight(GridMetadata* metadata, bool* has_light) {
  std::string text;
  FileResult result = takeText(metadata, "light", &text);
  if (!result.ok()) return result;
  *has_light = text == kPackedLight;
  if (*has_light || text == kNoLight) return {};
  return refuseText(FileStatus::value_out_of_range, "light", "none or axes (grids of earlier versions are to be baked again)",
                    text);
}

// The lines of a text of the metadata, which is taken out of it; false where there is none.
bool takeLines(const char* key, GridMetadata* metadata, std::string* text, std::vector<std::string>* lines) {
  const auto found = metadata->find(key);
  if (found == metadata->end()) return false;
  *text = std::move(found->second);
  metadata->erase(found);
  for (size_t begin = 0; begin <= text->size() && lines->size() <= kMaxLightGroups;) {
    const size_t end = std::min(text->find('\n', begin), text->size());
    lines->push_back(text->substr(begin, end - begin));
    begin = end + 1;
  }
  return true;
}

// Groups without light; none where all light is one.
FileResult takeGroups(GridMetadata* metadata, LightGrid* grid) {
  std::string text;
  std::vector<std::string> names, dark;
  takeLines("light_groups", metadata, &text, &names);
  if (names.size() > kMaxLightGroups) return refuseText(FileStatus::value_out_of_range, "light_groups", "16 names at most", text);
  for (std::string& name : names) grid->groups.push_back({std::move(name), {}});
  if (!takeLines("light_groups_dark", metadata, &text, &dark)) return {};
  // in their order, each once: the one text that is written of them
  for (LightGroup& group : grid->groups) group.begins_dark = std::find(dark.begin(), dark.end(), group.name) != dark.end();
  if (groupsText(*grid, true) != text)
    return refuseText(FileStatus::value_out_of_range, "light_groups_dark", "names of light_groups, in their order", text);
  return {};
}

// After the functions of probes, which say whose light there is, and the groups.
FileResult readLight(const TensorFileReader& reader, LightGrid* grid) {
  PackedLight& packed = grid->packed_light;
  std::vector<uint8_t> bits, records;
  std::vector<int32_t> offsets;
  std::vector<Half> axes;
  FileResult result = readNumbers<1>(reader, "light.unit", &packed.unit);
  takeFirst(&result, reader.read("light.bits", &bits));
  takeFirst(&result, reader.read("light.offsets", &offsets));
  takeFirst(&result, reader.read("light.axes", &axes));
  takeFirst(&result, reader.read("light.records", &records));
  if (result.ok() && bits.size() != offsets.size() + 1) result = refuseCount("light.bits", offsets.size() + 1, bits.size());
  if (result.ok() && axes.size() != offsets.size() * kShFloats)
    result = refuseCount("light.axes", offsets.size() * kShFloats, axes.size());
  if (!result.ok()) return result;
  packed.scale_bits = bits[0];
  for (size_t k = 0; k < offsets.size(); ++k) {
    LightAxis& axis = packed.axes.emplace_back();
    axis.bits = bits[k + 1];
    axis.offset = offsets[k];
    std::copy_n(axes.begin() + static_cast<ptrdiff_t>(k * kShFloats), kShFloats, axis.direction.begin());
  }
  result =
      decodeRecords(records, recordsBefore(grid->tree, grid->probe_function), std::max<size_t>(1, grid->groups.size()), &packed);
  return result.ok() ? takePackedLight(grid) : result;
}

FileResult readGrid(const TensorFileReader& reader, LightGrid* grid, GridMetadata* metadata) {
  *metadata = reader.metadata();
  bool has_light = false;
  FileResult result = takeIdentity(metadata);
  if (result.ok() && !reader.hasDigest()) result = refuse(FileStatus::digest_mismatch, kDigestMissing);
  if (result.ok()) result = takeHasLight(metadata, &has_light);
  if (result.ok() && has_light) result = takeGroups(metadata, grid);
  if (result.ok()) result = takeRepresentations(metadata, &grid->representations);
  if (!result.ok()) return result;
  for (const auto& [key, text] : *metadata) {
    if (isOwnKey(key)) return refuse(FileStatus::value_out_of_range, "metadata " + key + ": expected no such key");
  }
  result = readFunctions(reader, grid);
  if (result.ok()) result = readDictionaries(reader, grid);
  if (result.ok()) result = readTree(reader, grid);
  if (result.ok() && has_light) result = readLight(reader, grid);
  if (result.ok()) result = checkWithoutBricks(*grid);
  if (result.ok()) grid->makeBricks();
  return result;
}

// The tensors that codedBytes makes.
struct CodedTensors {
  std::vector<uint8_t> node_kind, node_bits, probe_kind, probe_function, function_representation, theta_groups, theta_steps,
      theta_halves;
};

CodedTensors codedTensors(const LightGrid& grid, const ProbeTreeData& tree, const PackedTheta& theta) {
  const PackedNodes nodes = packNodes(tree);
  const StoredProbes probes = storedProbes(grid.probe_function);
  std::vector<int> steps_of_function;
  size_t code = 0;
  for (const uint8_t r : grid.function_representation) {
    const Representation& of = grid.representations[r];
    steps_of_function.push_back(of.isCode() && !theta.groups.empty() ? kCodeGroup * (theta.groups[code++] % kCodeExponentUnit)
                                                                     : thetaForm(of, ThetaPrecision::int8).steps);
  }
  const ThetaColumns columns = thetaColumns(grid, steps_of_function);
  CodedTensors coded;
  coded.node_kind = codedBytes(nodes.kind);
  coded.node_bits = codedBytes(nodes.bits);
  coded.probe_kind = codedBytes(probes.kinds);
  coded.probe_function = codedBytes(bytesOfNames(probes.names), columnsOfNames(probes.names.size()));
  coded.function_representation = codedBytes(grid.function_representation);
  coded.theta_groups = codedBytes(theta.groups);
  if (!theta.steps.empty()) coded.theta_steps = codedBytes({theta.steps.begin(), theta.steps.end()}, columns.steps);
  if (!theta.halves.empty()) {
    std::vector<uint8_t> bytes;
    for (const Half half : theta.halves) {
      bytes.push_back(static_cast<uint8_t>(half.bits));
      bytes.push_back(static_cast<uint8_t>(half.bits >> 8));
    }
    coded.theta_halves = codedBytes(bytes, columns.halves);
  }
  return coded;
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
  const bool has_light = hasLight(grid, precision);
  const bool in_steps = precision.theta == ThetaPrecision::int8;
  takeFirst(&result, addOwnMetadata(grid, has_light, &texts));
  PackedLight light;
  if (result.ok() && has_light) {
    light = packedLightOf(grid, *precision.light_error);
    result = checkPackedLight(grid, light);
  }
  const std::vector<float> light_unit{light.unit};
  std::vector<uint8_t> light_bits{static_cast<uint8_t>(light.scale_bits)};
  std::vector<int32_t> light_offsets;
  std::vector<Half> light_axes;
  for (const LightAxis& axis : light.axes) {
    light_bits.push_back(static_cast<uint8_t>(axis.bits));
    light_offsets.push_back(axis.offset);
    light_axes.insert(light_axes.end(), axis.direction.begin(), axis.direction.end());
  }
  std::vector<uint8_t> light_records;
  if (result.ok() && has_light) light_records = codedRecords(light, recordsBefore(grid.tree, grid.probe_function));
  std::vector<Half> halves;
  PackedTheta packed;
  if (result.ok() && precision.theta == ThetaPrecision::float16) result = halvesOf(grid, &halves);
  if (result.ok() && in_steps) result = stepsOf(grid, &packed);
  if (!result.ok()) return result;
  std::vector<StoredDictionary> dictionaries(grid.representations.size());
  const std::vector<int> longest = longestCodes(grid, precision.theta);

  const ProbeTreeData tree = probeTreeData(grid.tree);
  const CodedTensors coded = codedTensors(grid, tree, packed);
  const std::vector<double> first_m(tree.frame.first_m.begin(), tree.frame.first_m.end()), spacing_m{tree.frame.spacing_m};
  const std::vector<int32_t> root_count(tree.frame.root_count.begin(), tree.frame.root_count.end());
  const std::vector<uint32_t> probe_count{static_cast<uint32_t>(grid.probe_function.size())};
  TensorFileWriter writer;
  writer.add("frame.first_m", first_m);
  writer.add("frame.spacing_m", spacing_m);
  writer.add("frame.root_count", root_count);
  writer.add("node.kind", coded.node_kind);
  writer.add("node.bits", coded.node_bits);
  writer.add("probe.count", probe_count);
  writer.add("probe.kind", coded.probe_kind);
  writer.add("probe.function", coded.probe_function);
  writer.add("function.representation", coded.function_representation);
  if (in_steps) {
    writer.add("theta.steps", coded.theta_steps);
    writer.add("theta.halves", coded.theta_halves);
    if (!packed.groups.empty()) writer.add("theta.groups", coded.theta_groups);
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
  if (has_light) {
    writer.add("light.unit", light_unit);
    writer.add("light.bits", light_bits);
    writer.add("light.offsets", light_offsets);
    writer.add("light.axes", light_axes);
    writer.add("light.records", light_records);
  }
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

size_t packedLightBytes(const LightGrid& grid) { return bytesOf(grid.packed_light, grid); }

LightGridBytes lightGridBytes(const LightGrid& grid, const GridPrecision& precision) {
  PackedTheta packed;
  if (precision.theta == ThetaPrecision::int8) stepsOf(grid, &packed);
  const CodedTensors coded = codedTensors(grid, probeTreeData(grid.tree), packed);
  size_t theta_bytes = coded.theta_steps.size() + coded.theta_halves.size() + coded.theta_groups.size();
  if (precision.theta != ThetaPrecision::int8)
    theta_bytes = grid.theta.size() * (precision.theta == ThetaPrecision::float16 ? sizeof(Half) : sizeof(float));
  size_t dictionary_bytes = 0;
  const std::vector<int> longest = longestCodes(grid, precision.theta);
  for (size_t r = 0; r < grid.representations.size(); ++r) {
    if (!grid.representations[r].isCode()) continue;
    const StoredDictionary stored = storedDictionary(grid.representations[r].dictionary->data(), longest[r]);
    dictionary_bytes += stored.nodes.size() + stored.exponents.size();
  }
  constexpr size_t kFrameBytes = sizeof(PositionM) + sizeof(double) + 3 * sizeof(int32_t);
  return {.light = hasLight(grid, precision) ? bytesOf(packedLightOf(grid, *precision.light_error), grid) : 0,
          .theta = theta_bytes,
          .dictionaries = dictionary_bytes,
          .functions = coded.function_representation.size(),
          .probe_function = sizeof(uint32_t) + coded.probe_kind.size() + coded.probe_function.size(),
          .tree = kFrameBytes + coded.node_kind.size() + coded.node_bits.size()};
}

}  // namespace nlg
