#include "validate/light/light_json.h"

#include <array>

#include <fmt/format.h>

namespace nlg {
namespace {

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
