#include "validate/light/light_figures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "validate/generators/statistics.h"

namespace nlg {
namespace {

constexpr uint64_t kTruthStream = 0x7472757468, kWalkTruthStream = 0x77616c6b;

double channelMean(const glm::vec3& rgb) { return (double{rgb.r} + rgb.g + rgb.b) / 3.0; }
double squares(const glm::vec3& rgb) { return (double{rgb.r} * rgb.r + double{rgb.g} * rgb.g + double{rgb.b} * rgb.b) / 3.0; }
double absolutes(const glm::vec3& rgb) { return double{std::fabs(rgb.r)} + std::fabs(rgb.g) + std::fabs(rgb.b); }
double quotient(double a, double b) { return b > 0.0 ? a / b : 0.0; }

// Steps of walks measure changes; places nearer than 5 cm and those at edges are figures of their own.
bool isCounted(const LightPlace& place) {
  const bool is_before = place.group == PlaceGroup::surface || place.group == PlaceGroup::turned;
  return place.group == PlaceGroup::air || (is_before && place.surface_class >= kFirstFarClass);
}

// What excess light is measured at: places where next to none should be.
bool isDark(const LightPlaces& places, const LightTruth& truth, size_t i) {
  return isCounted(places.places[i]) && channelMean(truth.at[i].irradiance) < kDarkShare * truth.mean;
}

// What a method answered, beside truth.
struct Measured {
  const LightPlaces& places;
  const LightTruth& truth;
  const std::vector<LightAnswer>& answers;  // by place

  const glm::vec3& expected(size_t i) const { return truth.at[i].irradiance; }
  const glm::vec3& answered(size_t i) const { return answers[i].irradiance; }
};

// Sums by room. Places in no room have none.
class RoomSums {
 public:
  explicit RoomSums(const LightPlaces& places) : count_(places.room_count), weight_(places.room_count), sum_(places.room_count) {}

  void add(const LightPlace& place, double value, double weight) {
    if (place.room >= count_.size()) return;
    ++count_[place.room];
    weight_[place.room] += weight;
    sum_[place.room] += weight * value;
  }
  bool says(uint32_t room) const { return room < count_.size() && count_[room] >= kLeastOfRoom; }
  double mean(uint32_t room) const { return quotient(sum_[room], weight_[room]); }

 private:
  std::vector<uint64_t> count_;
  std::vector<double> weight_, sum_;
};

// weightOf   a place's weight in the group; 0: not in it
template <class WeightOf>
GroupFigures groupFigures(const Measured& of, const WeightOf& weightOf) {
  const std::vector<LightPlace>& places = of.places.places;
  const double black = kBlackShare * of.truth.mean;
  GroupFigures figures;
  RoomSums room_light(of.places), room_errors(of.places);
  double weights = 0.0, error = 0.0, light = 0.0, answered = 0.0, expected = 0.0;
  for (size_t i = 0; i < places.size(); ++i) {
    const double weight = weightOf(places[i]);
    if (!(weight > 0.0)) continue;
    const glm::vec3 &truth = of.expected(i), &answer = of.answered(i);
    ++figures.places;
    weights += weight;
    error += weight * squares(answer - truth);
    light += weight * squares(truth);
    answered += weight * channelMean(answer);
    expected += weight * channelMean(truth);
    // what is below a hundredth of the level's mean is black to an eye: no share of it is an error
    const double sum = std::max(absolutes(answer) + absolutes(truth), black);
    figures.smape += weight * quotient(absolutes(answer - truth), sum);
    figures.unlit += weight * (of.answers[i].reach == Reach::unlit);
    figures.outside += weight * (of.answers[i].reach == Reach::outside);
    room_light.add(places[i], channelMean(truth), weight);
  }
  figures.rmse = std::sqrt(quotient(error, light));
  if (expected > 0.0) figures.energy = answered / expected;
  for (double* share : {&figures.smape, &figures.unlit, &figures.outside}) *share = quotient(*share, weights);
  // the same by room: every room weighs alike
  for (size_t i = 0; i < places.size(); ++i) {
    const double weight = weightOf(places[i]);
    if (!(weight > 0.0) || !room_light.says(places[i].room)) continue;
    const double own = std::max(channelMean(of.expected(i)), room_light.mean(places[i].room)), scale = std::max(own, black);
    room_errors.add(places[i], quotient(squares(of.answered(i) - of.expected(i)), scale * scale), weight);
  }
  for (uint32_t room = 0; room < of.places.room_count; ++room) {
    if (!room_errors.says(room)) continue;
    ++figures.rooms;
    figures.balanced += std::sqrt(room_errors.mean(room));
  }
  figures.balanced = quotient(figures.balanced, static_cast<double>(figures.rooms));
  return figures;
}

ExcessFigures darkFigures(const Measured& of) {
  ExcessFigures dark;
  for (size_t i = 0; i < of.answers.size(); ++i) {
    if (!isDark(of.places, of.truth, i)) continue;
    ++dark.places;
    dark.excess += channelMean(of.answered(i)) - channelMean(of.expected(i));
  }
  dark.excess = quotient(dark.excess, static_cast<double>(dark.places) * of.truth.mean);
  return dark;
}

ExcessFigures edgeFigures(const Measured& of, PlaceGroup group) {
  ExcessFigures figures;
  double light = 0.0, answered = 0.0;
  for (size_t i = 0; i < of.answers.size(); ++i) {
    if (of.places.places[i].group != group) continue;
    ++figures.places;
    light += channelMean(of.expected(i));
    answered += channelMean(of.answered(i));
  }
  figures.excess = quotient(answered - light, light);
  return figures;
}

WalkFigures walkFigures(const Measured& of) {
  std::vector<double> jumps;
  for (size_t i = 1; i < of.answers.size(); ++i) {
    const LightPlace &from = of.places.places[i - 1], &to = of.places.places[i];
    if (from.group != PlaceGroup::walk || to.group != PlaceGroup::walk || from.walk != to.walk) continue;
    const double answer = std::sqrt(squares(of.answered(i) - of.answered(i - 1)));
    const double expected = std::sqrt(squares(of.expected(i) - of.expected(i - 1)));
    jumps.push_back(quotient(std::max(0.0, answer - expected), of.truth.rms));
  }
  const Quantiles q = quantiles(jumps);
  return {q.count, q.mean, q.worst};
}

std::vector<WorstPlace> worstPlaces(const Measured& of) {
  std::vector<WorstPlace> all;
  for (uint32_t i = 0; i < of.answers.size(); ++i) {
    if (!isCounted(of.places.places[i])) continue;
    all.push_back({i, quotient(std::sqrt(squares(of.answered(i) - of.expected(i))), of.truth.rms)});
  }
  const size_t kept = std::min(all.size(), kWorstPlaceCount);
  std::partial_sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end(),
      [](const WorstPlace& a, const WorstPlace& b) { return a.error != b.error ? a.error > b.error : a.place < b.place; });
  all.resize(kept);
  return all;
}

using Json = nlohmann::ordered_json;

Json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json groupJson(const GroupFigures& f) {
  return {{"places", f.places},
          {"rmse", f.rmse},
          {"smape", f.smape},
          {"unlit", f.unlit},
          {"outside", f.outside},
          {"energy", f.energy},
          {"balanced", {{"rooms", f.rooms}, {"rmse", f.balanced}}}};
}

Json byDistanceJson(const GroupFigures& all, const std::array<GroupFigures, kSurfaceClassCount>& classes, int first_class) {
  Json json = groupJson(all);
  json["by_distance"] = Json::array();
  for (int c = first_class; c < kSurfaceClassCount; ++c) {
    json["by_distance"].push_back({{"from_m", kSurfaceBordersM[c]},
                                   {"to_m", kSurfaceBordersM[c + 1]},
                                   {"places", classes[c].places},
                                   {"rmse", classes[c].rmse}});
  }
  return json;
}

const char* groupName(PlaceGroup group) {
  constexpr std::array<const char*, 6> kNames = {"air", "surface", "turned", "walk", "edge", "corner"};
  return kNames[static_cast<size_t>(group)];
}

Json worstJson(const LightFigures& figures, const LightPlaces& places, const LightTruth& truth,
               const std::vector<LightAnswer>& answers, const glm::dvec3& origin_m) {
  Json json = Json::array();
  for (const WorstPlace& worst : figures.worst) {
    const LightPlace& place = places.places[worst.place];
    json.push_back({{"group", groupName(place.group)},
                    {"position_m", vectorJson(place.position_m + origin_m)},
                    {"normal", vectorJson(place.normal)},
                    {"truth", vectorJson(truth.at[worst.place].irradiance)},
                    {"answer", vectorJson(answers[worst.place].irradiance)},
                    {"error", worst.error}});
  }
  return json;
}

}  // namespace

LightTruth lightTruth(const LightPlaces& places, const LightTransport& transport, const TruthOptions& options) {
  LightTruth truth;
  truth.at.resize(places.places.size());
  parallelFor(places.places.size(), options.threads, [&](uint64_t i, int) {
    const LightPlace& place = places.places[i];
    // the same rays at all steps of a walk: what changes between steps is light, not noise
    const uint64_t place_seed = place.group == PlaceGroup::walk ? mixSeed(options.seed, kWalkTruthStream, place.walk)
                                                                : mixSeed(options.seed, kTruthStream, i);
    truth.at[i] = transport.gatherIrradiance(place.position_m, place.normal, options.gather, place_seed);
  });
  // over points in air alone: those before surfaces are drawn by classes of distance
  double count = 0.0, noise = 0.0, light = 0.0;
  for (size_t i = 0; i < truth.at.size(); ++i) {
    if (places.places[i].group != PlaceGroup::air) continue;
    count += 1.0;
    truth.mean += channelMean(truth.at[i].irradiance);
    light += squares(truth.at[i].irradiance);
    noise += squares(truth.at[i].deviation);
  }
  truth.mean = quotient(truth.mean, count);
  truth.rms = std::sqrt(quotient(light, count));
  truth.noise = std::sqrt(quotient(noise, light));
  // places that count as dark, for the reader to know how many leaks are measured on
  for (size_t i = 0; i < truth.at.size(); ++i) truth.dark += isDark(places, truth, i);
  return truth;
}

std::vector<Receiver> receiversAt(const LightPlaces& places) {
  std::vector<Receiver> receivers;
  for (const LightPlace& place : places.places) receivers.push_back({place.position_m, place.normal});
  return receivers;
}

LightFigures lightFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers) {
  const Measured of{places, truth, answers};
  LightFigures figures;
  figures.air = groupFigures(of, [](const LightPlace& p) { return p.group == PlaceGroup::air ? 1.0 : 0.0; });
  for (const bool is_turned : {false, true}) {
    const PlaceGroup group = is_turned ? PlaceGroup::turned : PlaceGroup::surface;
    (is_turned ? figures.turned : figures.surface) =
        groupFigures(of, [&](const LightPlace& p) { return p.group == group ? places.surfaceWeight(p.surface_class) : 0.0; });
    for (int c = 0; c < kSurfaceClassCount; ++c)
      (is_turned ? figures.turned_class : figures.surface_class)[c] =
          groupFigures(of, [&](const LightPlace& p) { return p.group == group && p.surface_class == c ? 1.0 : 0.0; });
  }
  figures.dark = darkFigures(of);
  figures.edge = edgeFigures(of, PlaceGroup::edge);
  figures.corner = edgeFigures(of, PlaceGroup::corner);
  figures.jumps = walkFigures(of);
  figures.worst = worstPlaces(of);
  return figures;
}

Json truthJson(const LightPlaces& places, const LightTruth& truth, bool is_baked) {
  uint64_t surface = 0;
  for (const uint64_t count : places.surface_count) surface += count;
  return {{"all_bounces_in_one_ray", is_baked},
          {"mean", truth.mean},
          {"rms", truth.rms},
          {"noise", truth.noise},
          {"places",
           {{"drawn", places.drawn},
            {"air", places.in_air},
            {"near_source", places.near_source},
            {"source_distance_m", places.source_distance_m},
            {"surface", surface},
            {"rooms", places.room_count},
            {"walks", places.walk_count},
            {"edges", places.edge_count},
            {"corners", places.corner_count},
            {"dark", truth.dark}}}};
}

std::string lightTable(const Json& spacings) {
  std::string table = fmt::format("{:>7} {:<48} {:>23}   {}\n", "spacing", "method", "RMSE", "energy: air, surface, turned");
  for (const Json& spacing : spacings) {
    for (const Json& method : spacing["methods"]) {
      const Json &air = method["air"], &surface = method["surface"], &turned = method["turned"];
      const std::string name = method["weights"].get<std::string>() + ", " + method["light"].get<std::string>();
      table += fmt::format("{:>5.3g} m {:<48}", spacing["spacing_m"].get<double>(), name);
      for (const char* key : {"rmse", "energy"}) {
        for (const Json* group : {&air, &surface, &turned}) table += fmt::format(" {:>7.3f}", (*group)[key].get<double>());
        table += "  ";
      }
      table += '\n';
    }
  }
  return table;
}

Json methodJson(const LightMethod& method, const LightFigures& figures, const LightPlaces& places, const LightTruth& truth,
                const std::vector<LightAnswer>& answers, const glm::dvec3& origin_m) {
  Json json = {{"weights", method.weights}, {"light", method.light}};
  json["air"] = groupJson(figures.air);
  json["surface"] = byDistanceJson(figures.surface, figures.surface_class, 0);
  json["turned"] = byDistanceJson(figures.turned, figures.turned_class, kFirstFarClass);
  for (const auto& [name, of] : {std::pair("dark", &figures.dark), {"edge", &figures.edge}, {"corner", &figures.corner}})
    json[name] = {{"places", of->places}, {"excess", of->excess}};
  json["jumps"] = {{"steps", figures.jumps.steps}, {"mean", figures.jumps.mean}, {"largest", figures.jumps.largest}};
  if (method.bytes.total() > 0) {
    json["bytes"] = {
        {"light", method.bytes.light},
        {"weights", method.bytes.weights},
        {"tree", method.bytes.tree},
        {"total", method.bytes.total()},
        {"per_probe", method.probes > 0 ? static_cast<double>(method.bytes.total()) / static_cast<double>(method.probes) : 0.0}};
    json["probes"] = method.probes;
  }
  json["worst"] = worstJson(figures, places, truth, answers, origin_m);
  json["times"] = {{"weights_s", method.weights_s}, {"light_s", method.light_s}};
  return json;
}

}  // namespace nlg
