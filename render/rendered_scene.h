// A scene with the methods that light its pictures.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/prepared_scene.h"
#include "light/light_transport.h"
#include "light/methods/light_method.h"
#include "light/methods/method_set.h"
#include "render/render_run.h"
#include "render/sight.h"

namespace nlg {

// place     the flag
// throws    UsageError on a name that no method has
void checkMethodName(const std::string& place, const std::string& name);
// As help names them: "trilinear, valid-trilinear, …".
std::string baselineNames();

class RenderedScene {
 public:
  // Loads the scene, and loads or bakes the grid. Both must outlive this object.
  // throws   UsageError, InputError
  RenderedScene(const RenderRequest& request, const BakeOptions& options);

  const Scene& scene() const { return source().scene; }
  const SceneSource& source() const { return baked_scene_ ? baked_scene_->source : source_; }
  const std::string& id() const { return source().id; }
  const std::vector<std::string>& lightNotes() const { return source().light_notes; }
  const LightTransport& transport() const { return *transport_; }
  const LightGrid& grid() const { return *grid_; }  // of requests that need one
  int threads() const { return threads_; }

  LightAt light(const std::string& name) const;
  // throws   UsageError when the scene has none of that name
  const LightMethod& baseline(const std::string& name) const;
  // What of a grid's file says that it is not of this scene, or not of its light here; told on stderr as well.
  const std::vector<std::string>& warnings() const { return warnings_; }
  // Of requests that name baselines; made when first asked for, by one thread.
  const MethodSet& baselines() const;

 private:
  void makeGrid(bool has_baselines);

  const RenderRequest& request_;
  const BakeOptions& options_;
  const int threads_;
  SceneSource source_;
  std::unique_ptr<RayScene> rays_;
  std::optional<PreparedScene> baked_scene_;  // in place of both: with what a bake and baselines need beside
  std::unique_ptr<LightTransport> transport_;
  std::optional<LightGrid> grid_;
  mutable std::unique_ptr<MethodSet> baselines_;
  std::vector<std::string> warnings_;
};

}  // namespace nlg
