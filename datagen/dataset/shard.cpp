#include "datagen/dataset/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datagen/dataset/hdf5_file.h"
#include "datagen/dataset/shard_fields.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kSchemaVersion = 1;
constexpr const char* kKind = "nlg-weighting-functions";
constexpr uint64_t kMaxPointCount = 65536;

// Where and why a shard breaks its contract; an empty place when it does not.
struct Fault {
  std::string place, expected, got;
};

std::vector<uint64_t> withRows(uint64_t rows, std::vector<uint64_t> columns) {
  columns.insert(columns.begin(), rows);
  return columns;
}

Fault pointCountFault(uint64_t point_count, uint64_t unseen_point_count) {
  const std::string expected = fmt::format("a multiple of 8, at most {}", kMaxPointCount);
  if (point_count == 0 || point_count > kMaxPointCount || point_count % 8 != 0) {
    return {"attribute point_count", expected + ", not 0", std::to_string(point_count)};
  }
  if (unseen_point_count > kMaxPointCount || unseen_point_count % 8 != 0) {
    return {"attribute unseen_point_count", expected, std::to_string(unseen_point_count)};
  }
  return {};
}

// phi of a point in solid is 0: every user may sum over all points without looking at validity.
Fault hiddenValueFault(const std::string& name, const std::vector<uint8_t>& phi, const std::vector<uint8_t>& validity,
                       uint64_t columns) {
  for (size_t byte = 0; byte < validity.size(); ++byte) {
    for (size_t bit = 0; bit < 8 && validity[byte] != 0xff; ++bit) {
      const size_t i = 8 * byte + bit;
      if (phi[i] == 0 || (validity[byte] >> bit & 1) != 0) continue;
      return {fmt::format("dataset {}: function {}, point {}", name, i / columns, i % columns), "0 at an invalid point",
              std::to_string(phi[i])};
    }
  }
  return {};
}

Fault placementFault(const Shard& shard) {
  for (size_t i = 0; i < shard.spacing_m.size(); ++i) {
    const float spacing_m = shard.spacing_m[i];
    if (std::isfinite(spacing_m) && spacing_m > 0) continue;
    return {fmt::format("dataset spacing_m: function {}", i), "a finite number above 0", fmt::format("{}", spacing_m)};
  }
  for (size_t i = 0; i < shard.probe_position_m.size(); ++i) {
    if (std::isfinite(shard.probe_position_m[i])) continue;
    return {fmt::format("dataset probe_position_m: function {}", i / 3), "finite numbers",
            fmt::format("{}", shard.probe_position_m[i])};
  }
  return {};
}

// What must hold of the values once all lengths are known to be right.
Fault valueFault(const Shard& shard) {
  Fault fault = placementFault(shard);
  if (!fault.place.empty()) return fault;
  fault = hiddenValueFault("phi", shard.phi, shard.validity, static_cast<uint64_t>(shard.point_count));
  if (!fault.place.empty()) return fault;
  return hiddenValueFault("phi_unseen", shard.phi_unseen, shard.validity_unseen, static_cast<uint64_t>(shard.unseen_point_count));
}

// The writer's promises: a shard that readShard would refuse is a bug of whoever made it.
void checkOwnPromises(const Shard& shard) {
  NLG_CHECK(shard.point_count, >=, 0);
  NLG_CHECK(shard.unseen_point_count, >=, 0);
  const Fault fault = pointCountFault(static_cast<uint64_t>(shard.point_count), static_cast<uint64_t>(shard.unseen_point_count));
  NLG_CHECK(fault.place, ==, "");
  NLG_CHECK(shard.counts.functions, ==, shard.functionCount());
  forEachArray(shard, [&](const char*, const auto& values, const std::vector<uint64_t>& columns) {
    NLG_CHECK(values.size(), ==, shard.functionCount() * rowWidth(columns));
  });
  NLG_CHECK(valueFault(shard).place, ==, "");
}

void writeTo(const std::string& path, const Shard& shard) {
  Hdf5Writer file(path);
  file.writeAttribute("kind", std::string(kKind));
  file.writeAttribute("schema_version", kSchemaVersion);
  file.writeAttribute("scene_id", shard.scene_id);
  file.writeAttribute("family", shard.family);
  file.writeAttribute("jitter", shard.jitter);
  file.writeAttribute("pattern_hash", shard.pattern_hash);
  file.writeAttribute("unseen_pattern_hash", shard.unseen_pattern_hash);
  file.writeAttribute("point_count", static_cast<uint64_t>(shard.point_count));
  file.writeAttribute("unseen_point_count", static_cast<uint64_t>(shard.unseen_point_count));
  file.writeAttribute("provenance_json", shard.provenance_json);
  forEachCount(shard.counts, [&](const char* name, uint64_t count) { file.writeAttribute(name, count); });
  forEachArray(shard, [&](const char* name, const auto& values, const std::vector<uint64_t>& columns) {
    file.write(name, withRows(shard.functionCount(), columns), values.data());
  });
  file.close();
}

void refuse(const std::string& path, const Fault& fault) {
  if (!fault.place.empty()) throw InputError(path, fault.place, fault.expected, fault.got);
}

void requirePattern(const std::string& path, uint64_t expected, uint64_t got) {
  if (expected == 0 || expected == got) return;
  throw InputError(path, "attribute pattern_hash", fmt::format("{:016x}", expected), fmt::format("{:016x}", got));
}

Shard readAttributes(const std::string& path, const Hdf5Reader& file, uint64_t pattern_hash, int expected_point_count) {
  const std::string kind = file.readTextAttribute("kind");
  if (kind != kKind) throw InputError(path, "attribute kind", kKind, kind);
  const uint64_t version = file.readIntegerAttribute("schema_version");
  if (version != kSchemaVersion) throw InputError(path, "attribute schema_version", "1", std::to_string(version));
  Shard shard;
  shard.scene_id = file.readTextAttribute("scene_id");
  shard.family = file.readTextAttribute("family");
  shard.jitter = file.readIntegerAttribute("jitter");
  shard.pattern_hash = file.readIntegerAttribute("pattern_hash");
  requirePattern(path, pattern_hash, shard.pattern_hash);
  shard.unseen_pattern_hash = file.readIntegerAttribute("unseen_pattern_hash");
  const uint64_t point_count = file.readIntegerAttribute("point_count");
  const uint64_t unseen_point_count = file.readIntegerAttribute("unseen_point_count");
  refuse(path, pointCountFault(point_count, unseen_point_count));
  if (expected_point_count != 0 && point_count != static_cast<uint64_t>(expected_point_count)) {
    throw InputError(path, "attribute point_count", std::to_string(expected_point_count), std::to_string(point_count));
  }
  shard.point_count = static_cast<int>(point_count);
  shard.unseen_point_count = static_cast<int>(unseen_point_count);
  shard.provenance_json = file.readTextAttribute("provenance_json");
  forEachCount(shard.counts, [&](const char* name, uint64_t& count) { count = file.readIntegerAttribute(name); });
  return shard;
}

}  // namespace

void writeShard(const std::string& path, const Shard& shard) {
  checkOwnPromises(shard);
  writeAtomically(path, [&](const std::string& temporary_path) { writeTo(temporary_path, shard); });
}

Shard readShard(const std::string& path, uint64_t pattern_hash, int point_count) {
  const Hdf5Reader file(path);
  Shard shard = readAttributes(path, file, pattern_hash, point_count);
  const uint64_t N = shard.counts.functions;
  forEachArray(shard, [&](const char* name, auto& values, const std::vector<uint64_t>& columns) {
    using Element = typename std::remove_reference_t<decltype(values)>::value_type;
    values = file.read<Element>(name, withRows(N, columns));
  });
  refuse(path, valueFault(shard));
  return shard;
}

Shard readShardHeader(const std::string& path, uint64_t pattern_hash, int point_count) {
  const Hdf5Reader file(path);
  Shard shard = readAttributes(path, file, pattern_hash, point_count);
  forEachArray(shard, [&](const char* name, const auto&, const std::vector<uint64_t>& columns) {
    const std::vector<uint64_t> expected = withRows(shard.counts.functions, columns), got = file.shape(name);
    if (got == expected) return;
    throw InputError(path, fmt::format("dataset {}", name), fmt::format("shape {}", fmt::join(expected, " x ")),
                     fmt::format("{}", fmt::join(got, " x ")));
  });
  return shard;
}

}  // namespace nlg
