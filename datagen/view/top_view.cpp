#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "datagen/view/image.h"
#include "datagen/view/legend.h"
#include "datagen/view/level_raster.h"
#include "datagen/view/shard_source.h"
#include "datagen/view/slice_panel.h"
#include "datagen/view/view.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kMargin = 32, kHeaderHeight = 126, kLegendHeight = 172, kMinWidth = 1500;

struct Box {
  glm::dvec3 low{1e300}, high{-1e300};
  void add(const glm::dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
};

// "2.5" in metres, "40%" as a share of the height of the box.
double parseHeight(const std::string& text, const Box& box) {
  size_t used = 0;
  double number = 0.0;
  try {
    number = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  const bool is_share = used > 0 && text.substr(used) == "%";
  if (used == 0 || !std::isfinite(number) || (!is_share && used != text.size()) || (is_share && (number < 0 || number > 100))) {
    throw UsageError("--height", "metres (2.5) or a share of the level's height (40%)", "'" + text + "'");
  }
  return is_share ? box.low.y + number / 100 * (box.high.y - box.low.y) : number;
}

// The level, and what the picture needs to know about it.
struct Level {
  std::vector<ViewTriangle> triangles;  // world, metres; empty without a scene
  Box box;                              // of the triangles, else of the probes' supports
  LevelMap map;
  double cut_m = 0.0;
};

Level makeLevel(const ViewedShard& viewed, const ViewOptions& options) {
  Level level;
  if (viewed.scene) level.triangles = trianglesNear(*viewed.scene, glm::dvec3(0.0), 1.0, std::numeric_limits<double>::infinity());
  for (const ViewTriangle& triangle : level.triangles) {
    for (const glm::dvec3& corner : triangle.corners) level.box.add(corner);
  }
  if (level.triangles.empty()) {
    for (uint64_t i = 0; i < viewed.shard.functionCount(); ++i) {
      for (const double sign : {-1.0, 1.0}) level.box.add(viewed.probePosition(i) + sign * viewed.shard.spacing_m[i]);
    }
  }
  level.map = makeLevelMap(level.box.low, level.box.high, options.level_px);
  level.cut_m = !options.height.empty()   ? parseHeight(options.height, level.box)
                : level.triangles.empty() ? level.box.high.y
                                          : mostTellingHeight(level.triangles, level.map, level.box.low.y, level.box.high.y);
  return level;
}

void drawCut(Image& image, const Level& level, const LevelMap& map) {
  const std::vector<CutSegment> cut = cutTriangles(level.triangles, 1, level.cut_m);
  for (const CutSegment& s : cut) drawCutLine(image, map.pixelOf(s.a), map.pixelOf(s.b), 2.2, s.double_sided);
}

// By level, coarse to fine: hues that neither the level's greys nor viridis have.
constexpr Colour kLevelColours[3] = {{40, 80, 220}, {235, 110, 10}, {214, 30, 130}};
constexpr double kLevelWidths[3] = {3.2, 2.0, 1.2};
constexpr Colour kCellInk{60, 60, 80};
constexpr double kCellShare = 0.35;
const Colour kKeyGround = heightColour(0.7);

void drawSquare(Image& image, const LevelMap& map, const glm::dvec3& low, double side_m, double width_px, Colour colour) {
  const glm::dvec2 a = map.pixelOf(low), b = map.pixelOf(low + side_m);
  drawLine(image, a, {b.x, a.y}, width_px, colour);
  drawLine(image, {b.x, a.y}, b, width_px, colour);
  drawLine(image, b, {a.x, b.y}, width_px, colour);
  drawLine(image, {a.x, b.y}, a, width_px, colour);
}

// The nodes and cells of the tree that the cut goes through; coarse nodes last, so that none of their lines is covered.
void drawTree(Image& image, const ViewedShard& viewed, const Level& level, const LevelMap& map) {
  const ProbeTreeFrame& frame = viewed.tree->frame();
  const glm::dvec3 first = viewed.scene->origin_m + glm::dvec3(frame.first_m[0], frame.first_m[1], frame.first_m[2]);
  const auto world = [&](const LatticePoint& p) { return first + frame.spacing_m * glm::dvec3(p[0], p[1], p[2]); };
  // half-open: of two cells one above another a cut between them goes through one
  const auto isCut = [&](const LatticePoint& low, int side) {
    const double bottom = world(low).y;
    return bottom <= level.cut_m && level.cut_m < bottom + side * frame.spacing_m;
  };
  // cells on a layer of their own, blended once: lines of neighbours fall together
  Image lines = image;
  viewed.tree->forEachCell([&](const ProbeCell& cell) {
    if (isCut(cell.low, cell.side)) drawSquare(lines, map, world(cell.low), cell.side * frame.spacing_m, 1.0, kCellInk);
  });
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) image.blend(x, y, lines.at(x, y), kCellShare);
  }
  // nodes with a brick, since others hold no probe
  std::vector<ProbeNode> nodes;
  viewed.tree->forEachNode([&](const ProbeNode& node) {
    if (node.brick_side > 0 && isCut(node.low, node.side)) nodes.push_back(node);
  });
  std::stable_sort(nodes.begin(), nodes.end(), [](const ProbeNode& a, const ProbeNode& b) { return a.level > b.level; });
  for (const ProbeNode& node : nodes) {
    drawSquare(image, map, world(node.low), node.side * frame.spacing_m, kLevelWidths[node.level], kLevelColours[node.level]);
  }
}

void drawProbe(Image& image, const glm::dvec2& at, double seen_share, bool is_above) {
  if (is_above) {
    drawRing(image, at, 4.0, 3.4, kBlack);
    drawRing(image, at, 4.0, 1.8, viridis(seen_share));
    return;
  }
  drawDisc(image, at, 5.0, kBlack);
  drawDisc(image, at, 4.0, viridis(seen_share));
}

void drawProbes(Image& image, const ViewedShard& viewed, const Level& level, const LevelMap& map) {
  for (uint64_t i = 0; i < viewed.shard.functionCount(); ++i) {
    const glm::dvec3 position = viewed.probePosition(i);
    drawProbe(image, map.pixelOf(position), viewed.seenShare(i), position.y > level.cut_m);
  }
}

void drawHeader(Image& image, const ViewedShard& viewed, const Level& level) {
  const ShardCounts& c = viewed.shard.counts;
  drawText(image, kMargin, 22, viewed.title() + ": from above", kInk, 2);
  const std::string place =
      viewed.scene ? fmt::format("cut at y = {} m, {} of the height from {} to {} m   right: x, down: z", fixed(level.cut_m, 2),
                                 percent((level.cut_m - level.box.low.y) / std::max(level.box.high.y - level.box.low.y, 1e-9)),
                                 fixed(level.box.low.y, 2), fixed(level.box.high.y, 2))
                   : "The scene is not at hand: only probes are drawn.";
  drawText(image, kMargin, 66, place, viewed.scene ? kInk : kWarning);
  drawText(
      image, kMargin, 88,
      fmt::format("{} of {} probes visited: {} functions, {} in free space, {} in solid, {} duplicates, {} empty, {} outside",
                  c.visited_probes, c.grid_probes, c.functions, c.free_space, c.in_solid, c.duplicates, c.empty, c.outside),
      kPaleInk);
}

void drawGeometryKeys(Image& image, int x, int y) {
  x = drawKey(image, x, y, "solid at the cut's height", [](Image& box) {
    for (int py = 0; py < box.height(); ++py) {
      for (int px = 0; px < box.width(); ++px) box.set(px, py, mix(heightColour(0.5), hatchColour(px, py), 0.6));
    }
  });
  for (const bool double_sided : {false, true}) {
    x = drawLineKey(image, x, y, double_sided ? "cut, double-sided" : "cut of a one-sided face", kKeyGround,
                    [&](Image& box, const auto& a, const auto& b) { drawCutLine(box, a, b, 2.2, double_sided); });
  }
}

void drawTreeKeys(Image& image, const ProbeTree& tree, int y) {
  int x = kMargin;
  for (int level = 0; level < 3; ++level) {
    const double side_m = kRootSide / std::pow(4.0, level) * tree.frame().spacing_m;
    x = drawLineKey(
        image, x, y, fmt::format("tree node, level {} ({} m)", level, fixed(side_m, 1)), kKeyGround,
        [&](Image& box, const auto& a, const auto& b) { drawLine(box, a, b, kLevelWidths[level], kLevelColours[level]); });
  }
  drawLineKey(image, x, y, "cells of their bricks, where the cut goes through", kKeyGround,
              [](Image& box, const auto&, const auto&) {
                for (const int at : {4, 12, 20}) drawLine(box, {at, 0}, {at, 18}, 1.0, mix(kKeyGround, kCellInk, kCellShare));
              });
}

void drawLegend(Image& image, const ViewedShard& viewed, const Level& level, const LevelMap& map, int y) {
  constexpr int kBarWidth = 300;
  drawColourBar(image, kMargin, y, kBarWidth, "probe: share of points it sees", {"0", "50 %", "100 %"}, viridis);
  int x = kMargin + kBarWidth + 60;
  if (!level.triangles.empty()) {
    drawColourBar(image, x, y, kBarWidth, "height of what is seen",
                  {fixed(level.box.low.y, 1), fixed(0.5 * (level.box.low.y + level.cut_m), 1), fixed(level.cut_m, 1) + " m"},
                  heightColour);
    x += kBarWidth + 60;
  }
  drawScaleBar(image, x, y + 50, map.px_per_m, std::min(400, map.width / 2));
  x = kMargin;
  for (const bool is_above : {false, true}) {
    x = drawLineKey(image, x, y + 84, is_above ? "probe above the cut" : "probe below the cut", kKeyGround,
                    [&](Image& box, const auto& a, const auto& b) { drawProbe(box, 0.5 * (a + b), 0.7, is_above); });
  }
  if (!level.triangles.empty()) drawGeometryKeys(image, x, y + 84);
  if (viewed.tree) drawTreeKeys(image, *viewed.tree, y + 116);
}

}  // namespace

void viewTop(const std::string& shard_path, const ViewOptions& options, const std::string& out_path) {
  if (options.level_px < 256 || options.level_px > 8192) {
    throw UsageError("level_px", "256 to 8192", std::to_string(options.level_px));
  }
  const ViewedShard viewed = loadViewedShard(shard_path, {.scene = options.scene, .with_tree = true});
  const Level level = makeLevel(viewed, options);
  const LevelMap& map = level.map;
  Image picture = drawLevel(level.triangles, map, level.box.low.y, level.cut_m);
  drawCut(picture, level, map);
  if (viewed.tree) drawTree(picture, viewed, level, map);
  drawProbes(picture, viewed, level, map);
  Image image(std::max(map.width + 2 * kMargin, kMinWidth), kHeaderHeight + map.height + kLegendHeight, kPaper);
  drawHeader(image, viewed, level);
  paste(image, picture, kMargin, kHeaderHeight);
  drawFrame(image, kMargin, kHeaderHeight, map.width, map.height, kPaleInk);
  drawLegend(image, viewed, level, map, kHeaderHeight + map.height + 24);
  writePng(out_path, image);
}

}  // namespace nlg
