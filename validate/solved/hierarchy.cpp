#include "validate/solved/hierarchy.h"

#include "validate/solved/approximation.h"
#include "validate/solved/walk.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

// Collects both lists, step by step.
class Hierarchy {
 public:
  explicit Hierarchy(const SolvedScene& scene) : scene_(scene) {}

  // after    error of the step that this one adds to; null for the first
  // returns  the lit result's error at the points of the solve
  double add(const std::string& step, const Json& representation, const BlendWeights& weights, const Json& function_rmse,
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

Json hierarchyJson(const SolvedScene& scene, const std::vector<Generator>& generators, const PolicyOptions& policy,
                   const DirectOptions& direct) {
  const DiffusionRule present{"present"}, bare_tent{"bare tent", Baseline::bare_tent};
  Hierarchy hierarchy(scene);
  hierarchy.addWalk("lighting itself", nullptr, walkTrueLight(scene));
  hierarchy.addWalk("bare tent", nullptr, walk(scene, generateWeights(scene.table, scene.views, scene.points, bare_tent)));
  const double solved = hierarchy.add("solved", nullptr, scene.solved.weights, nullptr, nullptr);
  const BlendWeights targets = generateWeights(scene.table, scene.views, scene.points, present);
  const double target = hierarchy.add("target", nullptr, targets, nullptr, &solved);
  const TargetFunctions functions = targetFunctions(scene, present);
  for (const Generator& generator : generators) {
    const Representation& representation = generator.representation();
    const auto add = [&](const char* step, const ThetaOfFunctions& theta, double after) {
      const Approximation approximation = approximate(scene, functions, representation, theta);
      return hierarchy.add(step, representationName(representation), approximation.weights, approximation.function_rmse_mean,
                           &after);
    };
    const auto words = thetaByWord(generator, functions, policy);
    const double best_known =
        add("best known", bestKnownTheta(generator, functions, words[static_cast<size_t>(ThetaWord::fitted)], direct), target);
    for (int word = 0; word < kThetaWordCount; ++word) add(wordName(static_cast<ThetaWord>(word)), words[word], best_known);
  }
  return hierarchy.take();
}

}  // namespace nlg
