#include "runtime_eval/grid_file/stored_functions.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

namespace nlg {
namespace {

constexpr const char* kDictionaryPrefix = "dictionary.";
constexpr const char *kNodesSuffix = ".nodes", *kExponentsSuffix = ".exponents";

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

FileResult readProbeFunctions(const TensorFileReader& reader, GridCounts* counts, std::vector<uint32_t>* probe_function) {
  uint32_t count = 0;
  std::vector<uint8_t> kinds, names;
  FileResult result = readNumbers<1>(reader, "probe.count", &count);
  counts->probes = count;
  // no count of a file takes memory before the file's size allows it
  takeFirst(&result, checkMemory(reader, *counts));
  const size_t bytes = (size_t{count} + kProbesAByte - 1) / kProbesAByte;
  if (result.ok()) result = readCoded(reader, "probe.kind", {}, &kinds, bytes);
  if (!result.ok()) return result;
  if (kinds.size() != bytes) return refuseCount("probe.kind", bytes, kinds.size());
  const auto kindOf = [&](size_t probe) { return kinds[probe / kProbesAByte] >> 2 * (probe % kProbesAByte) & 3; };
  // the kinds say how many names follow
  size_t named = 0;
  for (size_t probe = 0; probe < count; ++probe) named += kindOf(probe) == kNamedFunction;
  result = readCoded(reader, "probe.function", columnsOfNames(named), &names);
  if (!result.ok()) return result;
  uint32_t next = 0;
  const uint8_t* name = names.data();
  probe_function->reserve(count);
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
  // only grids with codes have groups
  if (!reader.dtypeOf("theta.groups").empty())
    result = readCoded(reader, "theta.groups", {}, &packed.groups, grid->functionCount());
  if (!result.ok()) return result;
  // functions whose representation does not exist are for checkLightGrid to name
  const auto representationOf = [&](uint8_t r) { return r < grid->representations.size() ? &grid->representations[r] : nullptr; };
  size_t code_count = 0;
  for (const uint8_t r : grid->function_representation)
    code_count += representationOf(r) != nullptr && representationOf(r)->isCode();
  if (packed.groups.size() != code_count) return refuseCount("theta.groups", code_count, packed.groups.size());
  // the steps of each function, which say what column each byte belongs to
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
  // halves were coded as bytes, the low one first
  for (size_t i = 0; i < half_bytes.size(); i += sizeof(Half))
    packed.halves.push_back({static_cast<uint16_t>(half_bytes[i] | half_bytes[i + 1] << 8)});
  const auto beyond = std::find(packed.steps.begin(), packed.steps.end(), int8_t{-128});
  if (beyond != packed.steps.end()) {
    return refuse(FileStatus::value_out_of_range,
                  "theta.steps: value " + std::to_string(beyond - packed.steps.begin()) + ": expected -127 to 127");
  }
  // a code is accepted only as its writer would have packed it, so that one grid has one file
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

FileResult readThetas(const TensorFileReader& reader, GridCounts* counts, LightGrid* grid) {
  FileResult result = readCoded(reader, "function.representation", {}, &grid->function_representation,
                                mostGridMemory(reader.byteCount()) / kLeastOfFunction);
  counts->functions = grid->functionCount();
  if (result.ok()) result = readProbeFunctions(reader, counts, &grid->probe_function);
  if (!result.ok()) return result;
  grid->theta_begin.reserve(grid->functionCount() + 1);
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
  // the resolution follows from the nodes of a row
  const auto nodesOf = [](int r) { return static_cast<size_t>(r) * r * r; };
  while (data.resolution < kMaxBrickResolution && rows * nodesOf(data.resolution) < stored.nodes.size()) ++data.resolution;
  const size_t nodes = nodesOf(data.resolution);
  if (stored.nodes.size() != rows * nodes) return refuseCount(name + kNodesSuffix, rows * nodes, stored.nodes.size());
  // rows that no code of the grid uses were left out: zeros stand for them, and 1 for deviations, which fits alone read
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
      result = readDictionary(reader, kDictionaryPrefix + std::to_string(r), longest[r], &grid->representations[r]);
  }
  return result;
}

// Which columns the theta of a grid have that were packed in int8.
ThetaColumns columnsOf(const LightGrid& grid, const PackedTheta& packed) {
  std::vector<int> steps_of_function;
  size_t code = 0;
  for (const uint8_t r : grid.function_representation) {
    const Representation& of = grid.representations[r];
    steps_of_function.push_back(of.isCode() ? kCodeGroup * (packed.groups[code++] % kCodeExponentUnit)
                                            : thetaForm(of, ThetaPrecision::int8).steps);
  }
  return thetaColumns(grid, steps_of_function);
}

FileResult storeSteps(const LightGrid& grid, StoredFunctions* stored) {
  PackedTheta packed;
  FileResult result = stepsOf(grid, &packed);
  if (!result.ok()) return result;
  const ThetaColumns columns = columnsOf(grid, packed);
  std::vector<uint8_t> bytes;
  for (const Half half : packed.halves) {
    bytes.push_back(static_cast<uint8_t>(half.bits));
    bytes.push_back(static_cast<uint8_t>(half.bits >> 8));
  }
  stored->groups = codedBytes(packed.groups);
  stored->steps = codedBytes({packed.steps.begin(), packed.steps.end()}, columns.steps);
  stored->step_halves = codedBytes(bytes, columns.halves);
  return result;
}

}  // namespace

FileResult storeFunctions(const LightGrid& grid, ThetaPrecision precision, StoredFunctions* stored) {
  *stored = {};
  const StoredProbes probes = storedProbes(grid.probe_function);
  stored->probe_count = {static_cast<uint32_t>(grid.probe_function.size())};
  stored->probe_kind = codedBytes(probes.kinds);
  stored->probe_function = codedBytes(bytesOfNames(probes.names), columnsOfNames(probes.names.size()));
  stored->function_representation = codedBytes(grid.function_representation);
  const std::vector<int> longest = longestCodes(grid, precision);
  for (size_t r = 0; r < grid.representations.size(); ++r) {
    const bool is_code = grid.representations[r].isCode();
    stored->dictionaries.push_back(is_code ? storedDictionary(grid.representations[r].dictionary->data(), longest[r])
                                           : StoredDictionary{});
  }
  if (precision == ThetaPrecision::int8) return storeSteps(grid, stored);
  if (precision == ThetaPrecision::float16) return halvesOf(grid, &stored->halves);
  stored->floats = grid.theta;
  return {};
}

void addTensors(const StoredFunctions& stored, ThetaPrecision precision, TensorFileWriter* writer) {
  writer->add("probe.count", stored.probe_count);
  writer->add("probe.kind", stored.probe_kind);
  writer->add("probe.function", stored.probe_function);
  writer->add("function.representation", stored.function_representation);
  if (precision == ThetaPrecision::int8) {
    writer->add("theta.steps", stored.steps);
    writer->add("theta.halves", stored.step_halves);
    if (!stored.groups.empty()) writer->add("theta.groups", stored.groups);
  } else if (precision == ThetaPrecision::float16) {
    writer->add("theta", stored.halves);
  } else {
    writer->add("theta", stored.floats);
  }
  for (size_t r = 0; r < stored.dictionaries.size(); ++r) {
    if (stored.dictionaries[r].exponents.empty()) continue;
    const std::string name = kDictionaryPrefix + std::to_string(r);
    writer->add(name + kNodesSuffix, stored.dictionaries[r].nodes);
    writer->add(name + kExponentsSuffix, stored.dictionaries[r].exponents);
  }
}

size_t thetaBytes(const StoredFunctions& stored) {
  return stored.groups.size() + stored.steps.size() + stored.step_halves.size() + stored.halves.size() * sizeof(Half) +
         stored.floats.size() * sizeof(float);
}

size_t dictionaryBytes(const StoredFunctions& stored) {
  size_t bytes = 0;
  for (const StoredDictionary& dictionary : stored.dictionaries) bytes += dictionary.nodes.size() + dictionary.exponents.size();
  return bytes;
}

FileResult readFunctions(const TensorFileReader& reader, GridCounts* counts, LightGrid* grid) {
  FileResult result = readThetas(reader, counts, grid);
  return result.ok() ? readDictionaries(reader, grid) : result;
}

}  // namespace nlg
