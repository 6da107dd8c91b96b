#include <fmt/format.h>

#include <algorithm>

#include "datagen/probes/shuffled_order.h"
#include "datagen/view/image.h"
#include "datagen/view/legend.h"
#include "datagen/view/shard_source.h"
#include "datagen/view/slice_panel.h"
#include "datagen/view/view.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kColumns = 8, kCellCount = 64;
constexpr int kMargin = 32, kGap = 10, kLabelHeight = 38, kHeaderHeight = 120, kLegendHeight = 130;

std::vector<uint64_t> randomFunctions(uint64_t count, uint64_t seed) {
  ShuffledOrder order(count, mixSeed(seed, 0x61746c6173));
  std::vector<uint64_t> chosen;
  uint64_t idx = 0;
  while (chosen.size() < kCellCount && order.next(&idx)) chosen.push_back(idx);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void drawCell(Image& image, const ViewedShard& viewed, uint64_t idx, int size, int x, int y) {
  const StoredFunction function = viewed.function(idx);
  const std::optional<std::vector<ViewTriangle>> triangles = viewed.localTriangles(idx);
  const std::vector<ViewTriangle>* near = triangles ? &*triangles : nullptr;
  const FunctionSlice slice = makeFunctionSlice(function, mostTellingPlane(function), size, near);
  paste(image, drawSlicePanel(slice, function, near, {.with_points = false, .cut_width_px = 1.4}), x, y);
  drawFrame(image, x, y, size, size, kPaleInk);
  constexpr const char* kPlanes[] = {"zy", "xz", "xy"};  // right, then up or down
  const uint8_t flags = viewed.shard.flags[idx];
  const std::string marks = std::string(flags & kFlagOpenShell ? " open" : "") + (flags & kFlagFewSeen ? " few" : "") +
                            (flags & kFlagInSolid ? " solid" : "");
  drawText(image, x, y + size + 2, fmt::format("{} {}", idx, kPlanes[slice.plane.normal]), kInk);
  drawText(image, x + size - textWidth(marks), y + size + 2, marks, kWarning);
  const std::string spacing = fixed(viewed.shard.spacing_m[idx], 2) + " m", seen = percent(viewed.seenShare(idx));
  std::string sizes = spacing + ", seen " + seen;
  if (textWidth(sizes) > size) sizes = seen;
  drawText(image, x, y + size + 2 + kGlyphHeight, sizes, kPaleInk);
}

}  // namespace

void viewAtlas(const std::string& shard_path, const ViewOptions& options, const std::string& out_path) {
  if (options.cell_px < 64 || options.cell_px > 1024) throw UsageError("cell_px", "64 to 1024", std::to_string(options.cell_px));
  const ViewedShard viewed = loadViewedShard(shard_path, {.scene = options.scene});
  // a sample by seed: another seed shows others
  const std::vector<uint64_t> chosen = randomFunctions(viewed.shard.functionCount(), options.seed);
  const int row_count = static_cast<int>((chosen.size() + kColumns - 1) / kColumns);
  const int step_x = options.cell_px + kGap, step_y = options.cell_px + kLabelHeight + kGap;
  // as wide as its text at least
  Image image(std::max(kColumns * step_x - kGap, 1560) + 2 * kMargin, kHeaderHeight + row_count * step_y + kLegendHeight, kPaper);
  drawText(image, kMargin, 22, viewed.title(), kInk, 2);
  drawText(image, kMargin, 66,
           fmt::format("{} of {} weighting functions, seed {}; of each the plane through the probe in which it differs most from "
                       "the bare tent",
                       chosen.size(), viewed.shard.functionCount(), options.seed),
           kInk);
  drawText(image, kMargin, 88,
           "index and plane (first axis right, second up; xz: z down), spacing, share of points that the probe sees", kPaleInk);
  if (!viewed.scene) drawText(image, kMargin + 1000, 30, "The scene is not at hand: no cut is drawn.", kWarning);
  for (size_t i = 0; i < chosen.size(); ++i) {
    const int column = static_cast<int>(i) % kColumns, row = static_cast<int>(i) / kColumns;
    drawCell(image, viewed, chosen[i], options.cell_px, kMargin + column * step_x, kHeaderHeight + row * step_y);
  }
  drawSliceLegend(image, kMargin, kHeaderHeight + row_count * step_y + 16, viewed.scene.has_value(), false);
  writePng(out_path, image);
}

}  // namespace nlg
