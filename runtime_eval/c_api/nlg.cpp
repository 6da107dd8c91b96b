#include "nlg/nlg.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "nlg/look_up.h"
#include "nlg/policy.h"
#include "nlg/simd.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/light_grid/grid_summary.h"

namespace {

using nlg::FileStatus;

// a status goes through the border as the same number
#define NLG_SAME(c_name, name) static_assert(c_name == static_cast<int>(FileStatus::name))
NLG_SAME(NLG_OK, ok);
NLG_SAME(NLG_CANNOT_OPEN, cannot_open);
NLG_SAME(NLG_CANNOT_READ, cannot_read);
NLG_SAME(NLG_TOO_SHORT, too_short);
NLG_SAME(NLG_HEADER_TOO_LARGE, header_too_large);
NLG_SAME(NLG_HEADER_MALFORMED, header_malformed);
NLG_SAME(NLG_TENSOR_MALFORMED, tensor_malformed);
NLG_SAME(NLG_TENSOR_MISSING, tensor_missing);
NLG_SAME(NLG_TENSOR_UNEXPECTED, tensor_unexpected);
NLG_SAME(NLG_VALUE_NOT_FINITE, value_not_finite);
NLG_SAME(NLG_VALUE_OUT_OF_RANGE, value_out_of_range);
NLG_SAME(NLG_VERSION_UNKNOWN, version_unknown);
NLG_SAME(NLG_PATTERN_UNKNOWN, pattern_unknown);
NLG_SAME(NLG_SIMD_UNAVAILABLE, simd_unavailable);
NLG_SAME(NLG_DIGEST_MISMATCH, digest_mismatch);
#undef NLG_SAME
static_assert(NLG_THETA_FLOAT32 == static_cast<int>(nlg::ThetaPrecision::float32));
static_assert(NLG_THETA_FLOAT16 == static_cast<int>(nlg::ThetaPrecision::float16));
static_assert(NLG_THETA_INT8 == static_cast<int>(nlg::ThetaPrecision::int8));
static_assert(NLG_LIT == static_cast<int>(nlg::LightStatus::lit));
static_assert(NLG_FAINT == static_cast<int>(nlg::LightStatus::faint));
static_assert(NLG_UNLIT == static_cast<int>(nlg::LightStatus::unlit));
static_assert(NLG_OUTSIDE == static_cast<int>(nlg::LightStatus::outside));
// lists go through the border as they are
static_assert(sizeof(nlg::PositionM) == 3 * sizeof(double) && sizeof(nlg::LightStatus) == sizeof(uint8_t));
static_assert(NLG_SUPPORT_POINT_COUNT == nlg::kSupportPointCount);
static_assert(sizeof(nlg::LocalPoint) == 3 * sizeof(float));

// Functions of one generate() call and points of one evaluate() call: what the caller gives is cut into such pieces.
constexpr size_t kFunctionsAtOnce = nlg::kBatchCount;
constexpr size_t kPointsAtOnce = 512;

// Memory is the only thing that runtime_eval may throw about; anything else would be our bug, and noexcept ends it here.
template <class Body>
nlg_status withMemory(const Body& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return NLG_OUT_OF_MEMORY;
  }
}

void fillDetail(std::string_view text, char* detail, size_t detail_size) {
  if (detail_size == 0 || detail == nullptr) return;
  size_t length = std::min(text.size(), detail_size - 1);
  // no half of a UTF-8 sequence
  while (length > 0 && length < text.size() && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
  std::memcpy(detail, text.data(), length);
  detail[length] = '\0';
}

}  // namespace

struct nlg_generator {
  nlg::Generator generator;
};

struct nlg_light_grid {
  nlg::LightGrid grid;
};

struct nlg_look_up_scratch {
  nlg::LookUpScratch scratch;
};

struct nlg_scratch {
  nlg_scratch(const nlg::Generator& made_for, const nlg::PolicyOptions& options)
      : of(&made_for), generator(made_for), policy({&made_for}, options), points(emptyPoints()), values(kPointsAtOnce) {}
  static nlg::PointSet emptyPoints() { return nlg::makePointSet(std::vector<nlg::LocalPoint>(kPointsAtOnce)); }
  const nlg::Generator* of;
  nlg::GeneratorScratch generator;
  nlg::ThetaPolicy policy;
  nlg::PointSet points;
  nlg::AlignedFloats values;
  nlg::FunctionChecker checker;
};

namespace {

// functionAt   (index) → StoredFunction or VisibilitySamples
template <class FunctionAt>
void generateAll(const FunctionAt& functionAt, size_t count, float* theta, nlg_scratch* scratch) noexcept {
  const auto theta_count = static_cast<size_t>(scratch->of->representation().thetaCount());
  for (size_t first = 0; first < count; first += kFunctionsAtOnce) {
    const size_t piece = std::min(kFunctionsAtOnce, count - first);
    decltype(functionAt(0)) functions[kFunctionsAtOnce];
    for (size_t i = 0; i < piece; ++i) functions[i] = functionAt(first + i);
    scratch->of->generate(functions, static_cast<int>(piece), theta + first * theta_count, &scratch->generator);
  }
}

// At most kPointsAtOnce points. Places between points.count and padded_count keep what they held: nobody reads what they yield.
void evaluatePiece(const nlg::Representation& representation, const float* theta, size_t count, const float* x, const float* y,
                   const float* z, float* values, nlg_scratch* scratch) noexcept {
  nlg::PointSet& points = scratch->points;
  points.count = static_cast<int>(count);
  points.padded_count = (points.count + nlg::kPointGroup - 1) / nlg::kPointGroup * nlg::kPointGroup;
  std::copy_n(x, count, points.x.begin());
  std::copy_n(y, count, points.y.begin());
  std::copy_n(z, count, points.z.begin());
  for (size_t i = 0; i < count; ++i) points.tent[i] = nlg::tent({x[i], y[i], z[i]});
  nlg::evaluate(representation, points, theta, scratch->values.data());
  std::copy_n(scratch->values.begin(), count, values);
}

nlg::PolicyOptions optionsOf(const nlg_policy_options& options) {
  nlg::PolicyOptions result;
#define NLG_CHOICE_OPTION(type, name, value, low, high, help)
#define NLG_POLICY_OPTION(type, name, value, low, high, help) result.name = options.name;
#include "nlg/policy_options.def"
  result.theta_precision = static_cast<nlg::ThetaPrecision>(options.theta_precision);
  return result;
}

nlg_check checkOf(const nlg::FunctionCheck& check, const nlg::CheckOptions& options) {
  return {check.rmse, check.blend_rmse, check.leak_mean, check.leak_share, check.passes(options) ? 1 : 0};
}

nlg_made madeOf(const nlg::MadeTheta& made, const nlg::CheckOptions& options) {
  const nlg::ThetaRecord& record = made.record;
  return {made.isBareTent() ? 0 : 1,
          record.took_fit ? 1 : 0,
          nlg::stageName(record.ended),
          checkOf(record.at(nlg::ThetaWord::network), options),
          checkOf(record.at(nlg::ThetaWord::corrected), options),
          checkOf(record.at(nlg::ThetaWord::fitted), options),
          checkOf(record.at(nlg::ThetaWord::stored), options),
          record.elapsedUs(nlg::ThetaWord::stored)};
}

template <class... Pointers>
bool isAnyNull(const Pointers*... pointers) {
  return (... || (pointers == nullptr));
}

nlg_status refuseArgument(std::string_view what, char* detail, size_t detail_size) {
  fillDetail(what, detail, detail_size);
  return NLG_INVALID_ARGUMENT;
}

// load(Held*) returns a FileResult; Handle{held} is what is handed out.
template <class Held, class Handle, class Load>
nlg_status loadHandle(bool has_source, const Load& load, Handle** handle, char* detail, size_t detail_size) noexcept {
  if (handle == nullptr)
    return refuseArgument("handle: expected an address for the result, got a null pointer", detail, detail_size);
  *handle = nullptr;
  if (!has_source) return refuseArgument("path or bytes: expected a source, got a null pointer", detail, detail_size);
  // nothing that is thrown crosses the border
  const nlg_status status = withMemory([&] {
    Held loaded;
    const nlg::FileResult result = load(&loaded);
    fillDetail(result.detail, detail, detail_size);
    if (result.ok()) *handle = new Handle{std::move(loaded)};
    return static_cast<nlg_status>(result.status);
  });
  if (status == NLG_OUT_OF_MEMORY) fillDetail("out of memory", detail, detail_size);
  return status;
}

template <class Load>
nlg_status loadGrid(bool has_source, const Load& load, nlg_light_grid** grid, char* detail, size_t detail_size) noexcept {
  return loadHandle<nlg::LightGrid>(
      has_source,
      [&](nlg::LightGrid* loaded) {
        nlg::GridMetadata texts;
        return load(loaded, &texts);
      },
      grid, detail, detail_size);
}

}  // namespace

extern "C" {

const char* nlg_status_name(nlg_status status) {
  if (status == NLG_OUT_OF_MEMORY) return "out_of_memory";
  if (status == NLG_INVALID_ARGUMENT) return "invalid_argument";
  return nlg::fileStatusName(static_cast<FileStatus>(status));
}

nlg_status nlg_generator_load(const char* path, nlg_generator** generator, char* detail, size_t detail_size) {
  return loadHandle<nlg::Generator>(
      path != nullptr, [&](nlg::Generator* loaded) { return nlg::Generator::load(path, loaded); }, generator, detail,
      detail_size);
}

nlg_status nlg_generator_load_bytes(const void* bytes, size_t byte_count, nlg_generator** generator, char* detail,
                                    size_t detail_size) {
  const bool has_source = bytes != nullptr || byte_count == 0;
  const std::string_view view =
      bytes != nullptr ? std::string_view(static_cast<const char*>(bytes), byte_count) : std::string_view();
  return loadHandle<nlg::Generator>(
      has_source, [&](nlg::Generator* loaded) { return nlg::Generator::parse(view, loaded); }, generator, detail, detail_size);
}

void nlg_generator_free(nlg_generator* generator) { delete generator; }

const char* nlg_representation_name(const nlg_generator* generator) {
  return generator == nullptr ? nullptr : nlg::representationName(generator->generator.representation());
}

float nlg_representation_slope(const nlg_generator* generator) {
  return generator == nullptr ? 0.0f : generator->generator.representation().slope;
}

size_t nlg_theta_count(const nlg_generator* generator) {
  return generator == nullptr ? 0 : static_cast<size_t>(generator->generator.representation().thetaCount());
}

const float* nlg_theta0(const nlg_generator* generator) { return generator == nullptr ? nullptr : generator->generator.theta0(); }

nlg_status nlg_support_pattern(const float** points_xyz, uint64_t* pattern_hash) {
  if (isAnyNull(points_xyz, pattern_hash)) return NLG_INVALID_ARGUMENT;
  return withMemory([&] {
    const nlg::SupportPattern& pattern = nlg::supportPattern();
    *points_xyz = pattern.points.front().data();
    *pattern_hash = pattern.hash;
    return NLG_OK;
  });
}

size_t nlg_sample_point(size_t sample) { return nlg::supportPointOf(static_cast<int>(sample)); }

nlg_policy_options nlg_default_policy(void) {
  nlg_policy_options options;
#define NLG_CHOICE_OPTION(type, name, value, low, high, help)
#define NLG_POLICY_OPTION(type, name, value, low, high, help) options.name = value;
#include "nlg/policy_options.def"
  options.theta_precision = static_cast<nlg_theta_precision>(nlg::PolicyOptions{}.theta_precision);
  return options;
}

const char* nlg_policy_out_of_range(const nlg_policy_options* options) {
  if (options == nullptr) return nullptr;
  if (options->theta_precision < NLG_THETA_FLOAT32 || options->theta_precision > NLG_THETA_INT8) return "theta_precision";
  return nlg::outOfRange(optionsOf(*options));
}

nlg_status nlg_scratch_create(const nlg_generator* generator, const nlg_policy_options* options, nlg_scratch** scratch) {
  if (scratch == nullptr) return NLG_INVALID_ARGUMENT;
  *scratch = nullptr;
  if (generator == nullptr) return NLG_INVALID_ARGUMENT;
  if (nlg_policy_out_of_range(options) != nullptr) return NLG_VALUE_OUT_OF_RANGE;
  return withMemory([&] {
    *scratch = new nlg_scratch(generator->generator, options != nullptr ? optionsOf(*options) : nlg::PolicyOptions{});
    return NLG_OK;
  });
}

void nlg_scratch_free(nlg_scratch* scratch) { delete scratch; }

int nlg_reads_samples(const nlg_generator* generator) {
  return generator != nullptr && generator->generator.readsSamples() ? 1 : 0;
}

void nlg_generate(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, size_t count, float* theta,
                  nlg_scratch* scratch) {
  if (isAnyNull(generator, phi, validity, theta, scratch)) return;
  generateAll(
      [&](size_t i) {
        return nlg::StoredFunction{phi + i * nlg::kSupportPointCount, validity + i * nlg::kValidityByteCount};
      },
      count, theta, scratch);
}

void nlg_generate_from_samples(const nlg_generator* generator, const uint8_t* seen, const uint8_t* validity, size_t count,
                               float* theta, nlg_scratch* scratch) {
  if (isAnyNull(generator, seen, validity, theta, scratch) || !generator->generator.readsSamples()) return;
  constexpr size_t kBytes = nlg::kSamplePointCount / 8;
  generateAll([&](size_t i) { return nlg::VisibilitySamples{seen + i * kBytes, validity + i * kBytes}; }, count, theta, scratch);
}

void nlg_evaluate(const nlg_generator* generator, const float* theta, size_t count, const float* x, const float* y,
                  const float* z, float* values, nlg_scratch* scratch) {
  if (isAnyNull(generator, theta, x, y, z, values, scratch)) return;
  for (size_t first = 0; first < count; first += kPointsAtOnce) {
    const size_t piece = std::min(kPointsAtOnce, count - first);
    evaluatePiece(generator->generator.representation(), theta, piece, x + first, y + first, z + first, values + first, scratch);
  }
}

nlg_check nlg_check_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          const float* theta, nlg_scratch* scratch) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (isAnyNull(generator, phi, validity, theta, scratch)) return {kNone, kNone, kNone, kNone, 0};
  const nlg::CheckOptions& check = scratch->policy.options().check();
  const nlg::StoredFunction function{phi, validity, nullptr, blend_sum};
  return checkOf(scratch->checker.check(generator->generator.representation(), function, theta, check), check);
}

nlg_status nlg_make_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          size_t count, float* theta, nlg_made* made, nlg_scratch* scratch) {
  if (isAnyNull(generator, scratch) || scratch->of != &generator->generator) return NLG_INVALID_ARGUMENT;
  if (count > 0 && isAnyNull(phi, validity, theta)) return NLG_INVALID_ARGUMENT;
  const auto theta_count = static_cast<size_t>(generator->generator.representation().thetaCount());
  return withMemory([&] {
    std::vector<nlg::StoredFunction> functions;
    // in the generator's batches: the memory of a call does not grow with its functions
    std::vector<nlg::MadeTheta> results(nlg::kBatchCount);
    for (size_t first = 0; first < count; first += nlg::kBatchCount) {
      const size_t piece = std::min<size_t>(nlg::kBatchCount, count - first);
      functions.clear();
      for (size_t i = first; i < first + piece; ++i) {
        functions.push_back({phi + i * nlg::kSupportPointCount, validity + i * nlg::kValidityByteCount, nullptr,
                             blend_sum != nullptr ? blend_sum + i * nlg::kSupportPointCount : nullptr});
      }
      scratch->policy.bake(functions.data(), static_cast<int>(piece), results.data());
      for (size_t i = 0; i < piece; ++i) {
        float* target = theta + (first + i) * theta_count;
        // a bare tent has no theta
        std::fill_n(target, theta_count, 0.0f);
        std::copy(results[i].theta.begin(), results[i].theta.end(), target);
        if (made != nullptr) made[first + i] = madeOf(results[i], scratch->policy.options().check());
      }
    }
    return NLG_OK;
  });
}

nlg_status nlg_light_grid_load(const char* path, nlg_light_grid** grid, char* detail, size_t detail_size) {
  return loadGrid(
      path != nullptr,
      [&](nlg::LightGrid* loaded, nlg::GridMetadata* texts) { return nlg::readLightGridFile(path, loaded, texts); }, grid, detail,
      detail_size);
}

nlg_status nlg_light_grid_load_bytes(const void* bytes, size_t byte_count, nlg_light_grid** grid, char* detail,
                                     size_t detail_size) {
  const bool has_source = bytes != nullptr || byte_count == 0;
  const std::string_view view =
      bytes != nullptr ? std::string_view(static_cast<const char*>(bytes), byte_count) : std::string_view();
  return loadGrid(
      has_source, [&](nlg::LightGrid* loaded, nlg::GridMetadata* texts) { return nlg::parseLightGrid(view, loaded, texts); },
      grid, detail, detail_size);
}

void nlg_light_grid_free(nlg_light_grid* grid) { delete grid; }

size_t nlg_light_grid_probe_count(const nlg_light_grid* grid) { return grid == nullptr ? 0 : grid->grid.tree.probeCount(); }

void nlg_light_grid_probe_positions(const nlg_light_grid* grid, double* positions_m) {
  if (isAnyNull(grid, positions_m)) return;
  for (size_t p = 0; p < grid->grid.tree.probeCount(); ++p) {
    const nlg::PositionM at = grid->grid.tree.probePosition(p);
    std::copy(at.begin(), at.end(), &positions_m[3 * p]);
  }
}

int nlg_light_grid_has_light(const nlg_light_grid* grid) { return grid == nullptr || grid->grid.light.empty() ? 0 : 1; }

void nlg_light_grid_bounds(const nlg_light_grid* grid, double* low_m, double* high_m) {
  if (isAnyNull(grid, low_m, high_m)) return;
  const nlg::GridBounds bounds = nlg::boundsOf(grid->grid.tree);
  std::copy(bounds.low_m.begin(), bounds.low_m.end(), low_m);
  std::copy(bounds.high_m.begin(), bounds.high_m.end(), high_m);
}

void nlg_light_grid_mean_radiance(const nlg_light_grid* grid, float* rgb) {
  if (isAnyNull(grid, rgb)) return;
  const auto mean = nlg::meanRadiance(grid->grid);
  std::copy(mean.begin(), mean.end(), rgb);
}

size_t nlg_light_grid_group_count(const nlg_light_grid* grid) { return grid == nullptr ? 0 : grid->grid.groups.size(); }

const char* nlg_light_grid_group_name(const nlg_light_grid* grid, size_t group) {
  return group < nlg_light_grid_group_count(grid) ? grid->grid.groups[group].name.c_str() : nullptr;
}

nlg_status nlg_light_grid_mix(nlg_light_grid* grid, const float* colours) {
  if (grid == nullptr) return NLG_INVALID_ARGUMENT;
  if (grid->grid.groups.empty()) return NLG_OK;
  if (colours == nullptr) return NLG_INVALID_ARGUMENT;
  return withMemory([&] {
    std::vector<std::array<float, 3>> of_groups(grid->grid.groups.size());
    for (size_t g = 0; g < of_groups.size(); ++g) std::copy_n(&colours[3 * g], 3, of_groups[g].begin());
    return nlg::mixLight(of_groups, &grid->grid).ok() ? NLG_OK : NLG_INVALID_ARGUMENT;
  });
}

nlg_light_status nlg_irradiance(const nlg_light_grid* grid, const double* position_m, const float* normal, float* rgb) {
  if (isAnyNull(grid, position_m, normal, rgb)) return NLG_OUTSIDE;
  const nlg::PositionM position{position_m[0], position_m[1], position_m[2]};
  return static_cast<nlg_light_status>(nlg::lookUpIrradiance(grid->grid, position, normal, rgb));
}

nlg_status nlg_look_up_scratch_create(nlg_look_up_scratch** scratch) {
  if (scratch == nullptr) return NLG_INVALID_ARGUMENT;
  *scratch = nullptr;
  if (nlg::forceSimdTargetFromEnvironment() != nlg::SimdStatus::ok) return NLG_SIMD_UNAVAILABLE;
  return withMemory([&] {
    *scratch = new nlg_look_up_scratch;
    return NLG_OK;
  });
}

void nlg_look_up_scratch_free(nlg_look_up_scratch* scratch) { delete scratch; }

void nlg_irradiances(const nlg_light_grid* grid, const double* positions_m, const float* normals, size_t count, float* rgb,
                     uint8_t* status, nlg_look_up_scratch* scratch) {
  if (isAnyNull(grid, positions_m, normals, rgb, status, scratch)) return;
  nlg::lookUpIrradiances(grid->grid, reinterpret_cast<const nlg::PositionM*>(positions_m), normals, count, rgb,
                         reinterpret_cast<nlg::LightStatus*>(status), &scratch->scratch);
}

}  // extern "C"
