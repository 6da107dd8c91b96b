#include "validate/solved/hierarchy.h"

#include "tool/error.h"
#include "tool/one_file_each.h"
#include "validate/solved/approximation.h"
#include "validate/solved/walk.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

// Collects both lists, step after step.
class Hierarchy {
 public:
  explicit Hierarchy(const SolvedScene& scene) : scene_(scene) {}

  // after    error of the step before; null for the first
  // returns  the lit result's error at the points of the solve
  double add(const std::string& step, const Json& representation, const Weights& weights, const Json& function_rmse,
             const double* after) {
    const Quality at_fit = judge(scene_, weights, PointUse::fit), at_test = judge(scene_, weights, PointUse::test);
    hierarchy_.push_back({{"scene", scene_.small.name},
                          {"step", step},
                          {"representation", representation},
                          {"rmse_mean", at_fit.rmse},
                          {"rmse_added", after ? Json(at_fit.rmse - *after) : Json(nullptr)},
                          {"rmse_occluded", at_fit.rmse_occluded},
                          {"rmse_test", at_test.rmse},
                          {"rmse_occluded_test", at_test.rmse_occluded},
                          {"unlit_share", at_fit.unlit_share},
                          {"leak", at_fit.leak},
                          {"distance_solved", at_fit.distance_solved},
                          {"function_rmse", function_rmse}});
    addWalk(step, representation, walk(scene_, weights));
    return at_fit.rmse;
  }

  void addWalk(const std::string& functions, const Json& representation, const WalkFigures& figures) {
    walks_.push_back({{"scene", scene_.small.name},
                      {"functions", functions},
                      {"representation", representation},
                      {"step_m", scene_.small.lattice.spacing_m / kSlicePixelsACell},
                      {"steps", figures.step_count},
                      {"weight_jump_p99", figures.weight_jump_p99},
                      {"weight_jump_worst", figures.weight_jump_worst},
                      {"light_jump_p99", figures.light_jump_p99},
                      {"light_jump_worst", figures.light_jump_worst}});
  }

  Json take() { return {{"hierarchy", std::move(hierarchy_)}, {"walks", std::move(walks_)}}; }

 private:
  const SolvedScene& scene_;
  Json hierarchy_ = Json::array(), walks_ = Json::array();
};

}  // namespace

std::vector<Generator> loadGenerators(const std::vector<std::string>& paths) {
  std::vector<Generator> generators(paths.size());
  OneFileEach given("--weights", "representation");
  for (size_t i = 0; i < paths.size(); ++i) {
    const WeightsResult loaded = Generator::load(paths[i], &generators[i]);
    if (!loaded.ok())
      throw InputError(paths[i], weightsStatusName(loaded.status), "a generator of this support pattern", loaded.detail);
    given.add(paths[i], representationName(generators[i].representation()));
  }
  return generators;
}

Json hierarchyJson(const SolvedScene& scene, const std::vector<Generator>& generators, const DirectOptions& direct) {
  const DiffusionRule present{"present"}, bare_tent{"bare tent", Baseline::bare_tent};
  Hierarchy hierarchy(scene);
  hierarchy.addWalk("lighting itself", nullptr, walkTrueLight(scene));
  hierarchy.addWalk("bare tent", nullptr, walk(scene, generateWeights(scene.table, scene.views, scene.points, bare_tent)));
  const double solved = hierarchy.add("solved", nullptr, scene.solved.weights, nullptr, nullptr);
  const Weights generated = generateWeights(scene.table, scene.views, scene.points, present);
  const double generated_rmse = hierarchy.add("generated", nullptr, generated, nullptr, &solved);
  for (const Generator& generator : generators) {
    const std::string name = representationName(generator.representation());
    const Approximation fitted = approximate(scene, present, generator.representation(), directFit(generator, direct));
    const double fitted_rmse = hierarchy.add("direct fit", name, fitted.weights, fitted.function_rmse_mean, &generated_rmse);
    const Approximation given = approximate(scene, present, generator.representation(), generatorFit(generator));
    hierarchy.add("generator", name, given.weights, given.function_rmse_mean, &fitted_rmse);
  }
  return hierarchy.take();
}

}  // namespace nlg
