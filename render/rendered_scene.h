// A scene with the methods that light its pictures.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/prepared_scene.h"
#include "light/light_transport.h"
#include "light/methods/light_method.h"
#include "light/methods/method_set.h"
#include "render/render_run.h"
#include "render/sight.h"

namespace nlg {

// What lights a picture: irradiance at receivers, by ground truth, by a light grid, or by any other method (light/methods/).
struct ReceivedLight {
  glm::vec3 irradiance{0.0f};  // >= 0
  glm::vec3 deviation{0.0f};   // standard deviation of its noise, where any is known
  bool is_lit = true;          // false: no light is known there, and irradiance is 0
};

struct Lighting {
  std::string name;
  // Fills received, as many as there are receivers; a pure function of each. Any number of threads may ask at once.
  std::function<void(std::span<const Receiver> receivers, ReceivedLight* received)> light_at;
};

// Ground truth: gathered or path traced at every receiver by itself.
// transport   must outlive the result
Lighting truthLighting(const LightTransport& transport, const GatherOptions& options, uint64_t seed);

// A light grid's look-up.
// grid       that holds light, in the world's coordinates; must outlive the result
// origin_m   the scene's
Lighting gridLighting(const LightGrid& grid, const glm::dvec3& origin_m);

// The share that one probe takes of the grid's blend at every receiver, as a grey irradiance.
Lighting probeShareLighting(const LightGrid& grid, const glm::dvec3& origin_m, uint32_t probe);

// Any other method.
// method   must outlive the result
Lighting measuredLighting(const std::string& name, const LightMethod& method);

// place     the flag
// throws    UsageError on a name that no method has
void checkMethodName(const std::string& place, const std::string& name);

// A baseline's name on the command line: "DDGI as shipped, relocated" is ddgi-as-shipped-relocated; behind a colon how its probes are
// lit, when that is not as baselines do (trilinear:solved).
std::string baselineName(const LightMethod& method);

class RenderedScene {
 public:
  // Loads the scene, loads or bakes the grid, and makes the baselines that the request names. Both must outlive this object.
  // throws   UsageError, InputError
  RenderedScene(const RenderRequest& request, const BakeOptions& options);

  const Scene& scene() const { return source().scene; }
  const SceneSource& source() const { return baked_scene_ ? baked_scene_->source : source_; }
  const std::string& id() const { return source().id; }
  const std::vector<std::string>& lightNotes() const { return source().light_notes; }
  const LightTransport& transport() const { return *transport_; }
  const LightGrid& grid() const { return *grid_; }  // of requests that need one
  int threads() const { return threads_; }

  Lighting lighting(const std::string& name) const;
  // throws   UsageError when the scene has none of that name
  const LightMethod& baseline(const std::string& name) const;
  // What of a grid's file says that it is not of this scene, or not of its light here; told on stderr as well.
  const std::vector<std::string>& warnings() const { return warnings_; }
  const MethodSet* baselines() const { return baselines_.get(); }  // null when none was asked for

 private:
  void makeGrid(bool has_baselines);
  void makeBaselines();

  const RenderRequest& request_;
  const BakeOptions& options_;
  const int threads_;
  SceneSource source_;
  std::unique_ptr<RayScene> rays_;
  std::optional<PreparedScene> baked_scene_;  // in place of both: with what a bake and baselines need beside
  std::unique_ptr<LightTransport> transport_;
  std::optional<LightGrid> grid_;
  std::unique_ptr<MethodSet> baselines_;
  std::vector<std::string> warnings_;
};

}  // namespace nlg
