#include "datagen/view/view.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>

#include "datagen/dataset/shard.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/shards/shard_scene.h"
#include "datagen/view/image.h"
#include "datagen/view/legend.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/support/point_order.h"
#include "scene/procedural/procedural.h"
#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

// HDF5 1.10.8 itself loses some hundred bytes for each damaged file that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace nlg {
namespace {

constexpr const char* kOptions =
    R"("seed":7,"unit":1.0,"move_m":0.5,"turn_degrees":20.0,"scale":0.15,"drop_share":0.1,"structure_share":0.35,)"
    R"("spacing_min_m":0.9,"spacing_max_m":1.1,"density_growth":0.5,"extent_m":[])";

// Probes that stand 50 m above house_3, where nothing is: bare tents.
Shard tentsOverAHouse(int count) {
  Shard shard;
  shard.scene_id = "house_3";
  shard.family = "house";
  shard.jitter = 2;
  shard.pattern_hash = supportPattern().hash;
  shard.test_pattern_hash = hashPoints({});
  shard.point_count = kSupportPointCount;
  shard.counts.functions = static_cast<uint64_t>(count);
  shard.provenance_json = std::string("{\"options\":{") + kOptions + "},\"inputs\":{}}";
  for (int i = 0; i < count; ++i) {
    for (const LocalPoint& point : supportPattern().points) {
      shard.phi.push_back(static_cast<uint8_t>(std::lround(255 * tent(point))));
    }
    shard.probe_position_m.insert(shard.probe_position_m.end(), {1.0 + 0.1 * i, 50.0, 2.0});
    shard.spacing_m.push_back(1.5f);
    shard.flags.push_back(static_cast<uint8_t>(i % 4));
  }
  shard.validity.assign(static_cast<size_t>(count) * kValidityByteCount, 0xff);
  shard.seen = shard.validity;
  shard.blend_sum.assign(shard.phi.size(), 255);
  return shard;
}

class View : public testing::Test {
 protected:
  void SetUp() override {
    options_.slice_px = 128;
    options_.cell_px = 64;
    options_.level_px = 256;
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string write(const Shard& shard, const std::string& name = "a.h5") const {
    writeShard(path(name), shard);
    return path(name);
  }

  const TemporaryFolder folder_;
  ViewOptions options_;
};

struct Decoded {
  int width = 0, height = 0;
  std::vector<uint8_t> bytes;
  Colour at(int x, int y) const {
    const uint8_t* p = &bytes[(static_cast<size_t>(y) * width + x) * 3];
    return {p[0], p[1], p[2]};
  }
};

Decoded decode(const std::string& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  header.format = PNG_FORMAT_RGB;
  Decoded decoded{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  decoded.bytes.resize(PNG_IMAGE_SIZE(header));
  EXPECT_NE(png_image_finish_read(&header, nullptr, decoded.bytes.data(), 0, nullptr), 0) << header.message;
  return decoded;
}

TEST_F(View, ProbeSlicesShowTheTentInItsColours) {
  options_.slice_px = 512;
  viewProbe(write(tentsOverAHouse(1)), 0, options_, path("x.png"));
  const Decoded picture = decode(path("x.png"));
  // margins of 32 px, a header of 164 px. Along the diagonal of a slice phi is (1 - d)², 1 in the middle under the probe's cross
  int checked_count = 0;
  for (int panel = 0; panel < 3; ++panel) {
    for (int at = 280; at < 500; at += 4) {
      const double d = (at + 0.5) / 256 - 1;
      const Colour got = picture.at(32 + panel * (512 + 32) + at, 164 + at), want = viridis((1 - d) * (1 - d));
      const int difference = std::abs(got.r - want.r) + std::abs(got.g - want.g) + std::abs(got.b - want.b);
      // rims of the dots that stand for support points lie on some of them
      checked_count += difference < 24;
    }
  }
  EXPECT_GT(checked_count, 3 * 55 * 8 / 10);
}

TEST(ShardScene, IsTheJitteredSceneOfTheRun) {
  const Shard shard = tentsOverAHouse(1);
  EXPECT_EQ(proceduralRequest(shard), "house:3");
  const Scene scene = rebuildShardScene(shard, "a.h5", "house:3");
  // the derivation, written out: shards that were made before depend on it
  uint64_t id_hash = 0;
  for (const char c : std::string("house_3")) id_hash = mixSeed(id_hash, static_cast<unsigned char>(c));
  const Scene expected = jitterScene(makeProceduralScene("house", 3), JitterOptions{}, mixSeed(7, id_hash, 2) | 1);
  EXPECT_EQ(scene.positions, expected.positions);
  EXPECT_EQ(scene.triangles, expected.triangles);
  EXPECT_NE(scene.positions, makeProceduralScene("house", 3).positions);
}

TEST(ShardScene, TreeIsThatOfTheOptions) {
  const Shard shard = tentsOverAHouse(1);
  const Scene scene = rebuildShardScene(shard, "a.h5", "house:3");
  const ProbeTree tree = rebuildShardTree(shard, "a.h5", scene);
  ProbePlacementOptions placement;
  placement.spacing_min_m = 0.9;
  placement.spacing_max_m = 1.1;
  const ProbeTree expected = placeProbes(scene, placement, shardSeed(7, "house_3", 2));
  ASSERT_EQ(tree.probeCount(), expected.probeCount());
  for (size_t i = 0; i < expected.probeCount(); ++i) EXPECT_EQ(tree.probePosition(i), expected.probePosition(i)) << i;
}

}  // namespace
}  // namespace nlg
