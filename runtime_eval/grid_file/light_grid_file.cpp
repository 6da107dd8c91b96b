#include "runtime_eval/grid_file/light_grid_file.h"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "runtime_eval/grid_file/light_records.h"
#include "runtime_eval/grid_file/stored_functions.h"
#include "runtime_eval/grid_file/tensor_reading.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"

namespace nlg {
namespace {

constexpr const char* kKind = "nlg-light-grid";
constexpr const char* kVersion = "2";
constexpr const char* kPackedLight = "axes";
constexpr const char* kNoLight = "none";
constexpr std::string_view kRepresentationPrefix = "representation.", kSlopePrefix = "slope.";

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

// As GridCounts has it.
uint64_t lightGroups(const LightGrid& grid, bool has_light) { return has_light ? std::max<size_t>(1, grid.groups.size()) : 0; }

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

FileResult readFrame(const TensorFileReader& reader, ProbeTreeFrame* frame) {
  FileResult result = readNumbers<3>(reader, "frame.first_m", frame->first_m.data());
  takeFirst(&result, readNumbers<1>(reader, "frame.spacing_m", &frame->spacing_m));
  takeFirst(&result, readNumbers<3>(reader, "frame.root_count", frame->root_count.data()));
  return result;
}

// Bricks of nodes with cells in use have slots for their corners.
void countNodes(const PackedNodes& nodes, GridCounts* counts) {
  counts->nodes = nodes.kind.size();
  for (const uint8_t kind : nodes.kind) {
    const uint64_t edge = (uint64_t{1} << (kind & 3)) + 1;
    counts->slots += kind >> 4 == 0 ? 0 : edge * edge * edge;
  }
}

void countRecords(const PackedLight& packed, GridCounts* counts) {
  counts->words = static_cast<uint64_t>(lightWords(packed));
  counts->fields = packed.axes.size() + 1;
}

FileResult refuseTree(const std::string& fault) {
  return fault.empty() ? FileResult{} : refuse(FileStatus::value_out_of_range, "probe tree: " + fault);
}

// After probe_function, which says how many probes there are.
FileResult readTree(const TensorFileReader& reader, GridCounts* counts, LightGrid* grid) {
  ProbeTreeData data;
  PackedNodes nodes;
  FileResult result = readFrame(reader, &data.frame);
  takeFirst(&result, readCoded(reader, "node.kind", {}, &nodes.kind, mostGridMemory(reader.byteCount()) / kLeastOfNode));
  countNodes(nodes, counts);
  if (result.ok()) result = checkMemory(reader, *counts);
  if (result.ok()) result = readCoded(reader, "node.bits", {}, &nodes.bits, 16 * nodes.kind.size());
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
    return refuseText(FileStatus::version_unknown, "version", std::string(kVersion) + " (bake grids of earlier versions again)",
                      version);
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
    // a code gets its dictionary once theta is read (readDictionaries)
    representations->push_back(representation);
  }
  return {};
}

FileResult takeHasLight(GridMetadata* metadata, bool* has_light) {
  std::string text;
  FileResult result = takeText(metadata, "light", &text);
  if (!result.ok()) return result;
  *has_light = text == kPackedLight;
  if (*has_light || text == kNoLight) return {};
  return refuseText(FileStatus::value_out_of_range, "light", "none or axes (bake grids of earlier versions again)", text);
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
FileResult readLight(const TensorFileReader& reader, GridCounts* counts, LightGrid* grid) {
  PackedLight& packed = grid->packed_light;
  std::vector<uint8_t> bits, records;
  std::vector<int32_t> offsets;
  std::vector<Half> axes;
  FileResult result = readNumbers<1>(reader, "light.unit", &packed.unit);
  takeFirst(&result, reader.read("light.bits", &bits));
  takeFirst(&result, reader.read("light.offsets", &offsets));
  takeFirst(&result, reader.read("light.axes", &axes));
  takeFirst(&result, reader.read("light.records", &records));
  // the lists must fit each other before anything is built of them
  if (result.ok() && bits.size() != offsets.size() + 1) result = refuseCount("light.bits", offsets.size() + 1, bits.size());
  if (result.ok() && axes.size() != offsets.size() * kShFloats)
    result = refuseCount("light.axes", offsets.size() * kShFloats, axes.size());
  if (!result.ok()) return result;
  packed.scale_bits = bits[0];
  for (size_t k = 0; k < offsets.size(); ++k) {
    LightAxis& axis = packed.axes.emplace_back();
    axis.bits = bits[k + 1];
    axis.offset = offsets[k];
    std::transform(&axes[k * kShFloats], &axes[k * kShFloats] + kShFloats, axis.direction.begin(),
                   [](Half half) { return half.bits; });
  }
  // what the records would need is bounded by the file's size before they are decoded
  result = checkLightLayout(packed);
  countRecords(packed, counts);
  if (result.ok()) result = checkMemory(reader, *counts);
  if (!result.ok()) return result;
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
  // all keys of its own have been taken out: one that is left means nothing to this reader
  for (const auto& [key, text] : *metadata) {
    if (isOwnKey(key)) return refuse(FileStatus::value_out_of_range, "metadata " + key + ": expected no such key");
  }
  GridCounts counts{.representations = grid->representations, .light_groups = lightGroups(*grid, has_light)};
  // functions say how many probes there are and which have light, the tree which of them are neighbours
  result = readFunctions(reader, &counts, grid);
  if (result.ok()) result = readTree(reader, &counts, grid);
  if (result.ok() && has_light) result = readLight(reader, &counts, grid);
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
  const bool has_light = hasLight(grid, precision);
  takeFirst(&result, addOwnMetadata(grid, has_light, &texts));
  PackedLight light;
  if (result.ok() && has_light) {
    light = packedLightOf(grid, *precision.light_error);
    result = checkPackedLight(grid, light);
  }
  // the writer keeps addresses: every list stays until it has serialised
  const std::vector<float> light_unit{light.unit};
  std::vector<uint8_t> light_bits{static_cast<uint8_t>(light.scale_bits)};
  std::vector<int32_t> light_offsets;
  std::vector<Half> light_axes;
  for (const LightAxis& axis : light.axes) {
    light_bits.push_back(static_cast<uint8_t>(axis.bits));
    light_offsets.push_back(axis.offset);
    for (const uint16_t bits : axis.direction) light_axes.push_back({bits});
  }
  std::vector<uint8_t> light_records;
  if (result.ok() && has_light) light_records = codedRecords(light, recordsBefore(grid.tree, grid.probe_function));
  StoredFunctions functions;
  if (result.ok()) result = storeFunctions(grid, precision.theta, &functions);
  if (!result.ok()) return result;

  // the tree goes without its slots: a reader numbers the probes as the builder did
  const ProbeTreeData tree = probeTreeData(grid.tree);
  const PackedNodes nodes = packNodes(tree);
  const std::vector<uint8_t> node_kind = codedBytes(nodes.kind), node_bits = codedBytes(nodes.bits);
  const std::vector<double> first_m(tree.frame.first_m.begin(), tree.frame.first_m.end()), spacing_m{tree.frame.spacing_m};
  const std::vector<int32_t> root_count(tree.frame.root_count.begin(), tree.frame.root_count.end());
  TensorFileWriter writer;
  writer.add("frame.first_m", first_m);
  writer.add("frame.spacing_m", spacing_m);
  writer.add("frame.root_count", root_count);
  addTensors(functions, precision.theta, &writer);
  writer.add("node.kind", node_kind);
  writer.add("node.bits", node_bits);
  if (has_light) {
    writer.add("light.bits", light_bits);
    writer.add("light.records", light_records);
    writer.add("light.unit", light_unit);
    writer.add("light.offsets", light_offsets);
    writer.add("light.axes", light_axes);
  }
  // readers bound their memory by the file's size: a grid that packs better than that gets room beside it
  GridCounts counts{grid.representations, grid.functionCount(), grid.probe_function.size()};
  counts.light_groups = lightGroups(grid, has_light);
  countNodes(nodes, &counts);
  if (has_light) countRecords(light, &counts);
  result = writer.serialize(texts, bytes);
  const uint64_t most = mostGridMemory(bytes->size()), memory = counts.memory();
  if (!result.ok() || memory <= most) return result;
  // up to 1 MB bytes are for the rule alone
  const uint64_t least = std::max<uint64_t>(bytes->size(), kSmallGridFile);
  const std::vector<uint8_t> room(least - bytes->size() + (memory - std::min(memory, mostGridMemory(least))) / 256 + 1);
  writer.add("room", room);  // readers pass it by
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
  StoredFunctions functions;
  storeFunctions(grid, precision.theta, &functions);
  const PackedNodes nodes = packNodes(probeTreeData(grid.tree));
  constexpr size_t kFrameBytes = sizeof(PositionM) + sizeof(double) + 3 * sizeof(int32_t);
  return {.light = hasLight(grid, precision) ? bytesOf(packedLightOf(grid, *precision.light_error), grid) : 0,
          .theta = thetaBytes(functions),
          .dictionaries = dictionaryBytes(functions),
          .functions = functions.function_representation.size(),
          .probe_function = sizeof(uint32_t) + functions.probe_kind.size() + functions.probe_function.size(),
          .tree = kFrameBytes + codedBytes(nodes.kind).size() + codedBytes(nodes.bits).size()};
}

}  // namespace nlg
