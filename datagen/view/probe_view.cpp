#include <fmt/format.h>

#include <algorithm>

#include "datagen/view/image.h"
#include "datagen/view/legend.h"
#include "datagen/view/shard_source.h"
#include "datagen/view/slice_panel.h"
#include "datagen/view/view.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kMargin = 32, kHeaderHeight = 164, kLegendHeight = 140, kMinWidth = 1560;

std::string flagsText(uint8_t flags) {
  std::string text;
  if (flags & kFlagOpenShell) text += "open shell (votes about solid disputed)";
  if (flags & kFlagFewSeen) text += std::string(text.empty() ? "" : ", ") + "few seen (below 1 %)";
  if (flags & kFlagInSolid) text += std::string(text.empty() ? "" : ", ") + "in solid (seen from an eye in air)";
  return text.empty() ? "none" : text;
}

void drawHeader(Image& image, const ViewedShard& viewed, uint64_t idx) {
  const Shard& shard = viewed.shard;
  drawText(image, kMargin, 22, viewed.title() + ": probe " + std::to_string(idx), kInk, 2);
  drawText(image, kMargin, 66,
           fmt::format("position {}   spacing {} m   flags: {}", positionText(viewed.probePosition(idx)),
                       fixed(shard.spacing_m[idx], 3), flagsText(shard.flags[idx])),
           kInk);
  std::string shares = fmt::format("of the support points {} are valid, {} are seen by the probe",
                                   percent(viewed.validShare(idx)), percent(viewed.seenShare(idx)));
  drawText(image, kMargin, 88, shares, kInk);
  if (!viewed.scene) {
    drawText(image, kMargin, 110, "The scene is not at hand: no cut is drawn, every pixel shows its nearest support point.",
             kWarning);
  }
}

// Where the probe itself stands: the middle of every slice.
void drawProbe(Image& panel) {
  const glm::dvec2 centre(0.5 * panel.width());
  for (const double extra : {2.0, 0.0}) {
    const Colour colour = extra > 0 ? kBlack : kWhite;
    for (const glm::dvec2& arm : {glm::dvec2(9, 0), glm::dvec2(0, 9)})
      drawLine(panel, centre - arm, centre + arm, 2.0 + extra, colour);
  }
}

std::string panelTitle(const PlaneView& plane, const glm::dvec3& position_m) {
  constexpr char kNames[] = "xyz";
  return fmt::format("{} = {} m     right: {}, {}: {}", kNames[plane.normal], fixed(position_m[plane.normal], 3),
                     kNames[plane.right], plane.up_sign > 0 ? "up" : "down", kNames[plane.up]);
}

}  // namespace

void viewProbe(const std::string& shard_path, uint64_t probe_idx, const ViewOptions& options, const std::string& out_path) {
  if (options.slice_px < 128 || options.slice_px > 4096) {
    throw UsageError("slice_px", "128 to 4096", std::to_string(options.slice_px));
  }
  const ViewedShard viewed = loadViewedShard(shard_path, {.scene = options.scene});
  if (probe_idx >= viewed.shard.functionCount()) {
    throw UsageError("--probe", "0 to " + std::to_string(viewed.shard.functionCount() - 1) + ", the functions of " + shard_path,
                     std::to_string(probe_idx));
  }
  const int size = options.slice_px;
  Image image(std::max(3 * size + 4 * kMargin, kMinWidth), kHeaderHeight + size + kLegendHeight, kPaper);
  drawHeader(image, viewed, probe_idx);
  const StoredFunction function = viewed.function(probe_idx);
  const std::optional<std::vector<ViewTriangle>> triangles = viewed.localTriangles(probe_idx);
  int x = kMargin;
  // as seen from the front, from above, and from the side
  for (const int normal : {2, 1, 0}) {
    const FunctionSlice slice = makeFunctionSlice(function, normal, size, triangles ? &*triangles : nullptr);
    Image panel = drawSlicePanel(slice, function, triangles ? &*triangles : nullptr, {});
    drawProbe(panel);
    paste(image, panel, x, kHeaderHeight);
    drawFrame(image, x, kHeaderHeight, size, size, kPaleInk);
    drawText(image, x, kHeaderHeight - 24, panelTitle(slice.plane, viewed.probePosition(probe_idx)), kInk);
    x += size + kMargin;
  }
  drawScaleBar(image, image.width() - kMargin - 340, kHeaderHeight + size + 24 + 40,
               0.5 * size / viewed.shard.spacing_m[probe_idx], 320);
  drawSliceLegend(image, kMargin, kHeaderHeight + size + 24, viewed.scene.has_value(), true);
  writePng(out_path, image);
}

}  // namespace nlg
