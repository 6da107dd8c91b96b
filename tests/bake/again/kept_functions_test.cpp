// What a bake keeps for the next: the next one leaves the bytes of a whole bake, whatever has changed, and does less.
#include "bake/again/kept_functions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/again/kept_functions_file.h"
#include "bake/scene_bake.h"
#include "tests/bake/house_corner.h"
#include "tests/damage.h"
#include "tests/input_error.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

using Change = std::function<void(Scene&)>;

const std::vector<Generator>& generators() {
  static const std::vector<Generator> made = sampleGenerators();
  return made;
}

std::vector<Representation> representations() { return {generators().front().representation()}; }

BakeOptions cornerOptions() {
  BakeOptions options = houseCornerOptions(2);
  options.light = "none";  // a bake makes all of it, whatever was kept
  takeThetaPrecision(&options);
  return options;
}

struct Result {
  std::string grid;
  BakeStatistics statistics;
};

Result bakeHouse(const Change& change, KeptThetas* kept, int threads = 2) {
  BakeOptions options = cornerOptions();
  options.threads = threads;
  SceneSource lit = loadLitScene("house:3", options);
  change(lit.scene);
  const PreparedScene scene(std::move(lit), options);
  Bake bake = bakeScene(scene, generators(), options, std::filesystem::temp_directory_path().string(), {}, kept);
  Result result{{}, std::move(bake.statistics)};
  const FileResult written =
      serializeLightGrid(bake.grid, {options.policy.theta_precision, options.light_error}, {}, &result.grid);
  EXPECT_TRUE(written.ok()) << written.detail;
  return result;
}

void leaveAsItIs(Scene&) {}

// What lies wholly in half of the corner's width, moved by 10 cm.
void moveSomething(Scene& scene) {
  std::vector<bool> moves(scene.positions.size());
  size_t moved = 0;
  for (const glm::uvec3& triangle : scene.triangles) {
    const auto isInside = [&](uint32_t corner) {
      const glm::dvec3 at = scene.origin_m + glm::dvec3(scene.positions[corner]);
      return at.x > 0.5 && at.x < 3.0 && at.y > 0.2 && at.y < 3.0 && at.z > 0.5 && at.z < 5.0;
    };
    if (!isInside(triangle.x) || !isInside(triangle.y) || !isInside(triangle.z)) continue;
    for (int k = 0; k < 3; ++k) moves[triangle[k]] = true;
    ++moved;
  }
  for (size_t i = 0; i < moves.size(); ++i) scene.positions[i].x += moves[i] ? 0.1f : 0.0f;
  ASSERT_GT(moved, 0u);
}

// No triangle moves, but no ray finds evidence of solid any more.
void seeBothSides(Scene& scene) {
  for (Material& material : scene.materials) material.double_sided = true;
}

// The same triangles, as another exporter may order them.
void reorder(Scene& scene) {
  std::reverse(scene.triangles.begin(), scene.triangles.end());
  std::reverse(scene.triangle_material.begin(), scene.triangle_material.end());
}

class KeptFunctions : public testing::Test {
 protected:
  static void SetUpTestSuite() { first_ = new First; }
  static void TearDownTestSuite() { delete std::exchange(first_, nullptr); }

  void expectWholeBakesBytes(const Change& change) {
    now_ = bakeHouse(change, &kept_);
    const Result whole = bakeHouse(change, nullptr);
    EXPECT_TRUE(now_.grid == whole.grid);
    EXPECT_EQ(now_.statistics.blend, whole.statistics.blend);
  }

  struct First {
    KeptThetas kept;
    Result result = bakeHouse(leaveAsItIs, &kept);
  };
  static inline const First* first_ = nullptr;

  KeptThetas kept_ = first_->kept;
  const Result& before_ = first_->result;
  Result now_;
};

TEST_F(KeptFunctions, AMovedWallCostsWhatItTouches) {
  expectWholeBakesBytes(moveSomething);
  EXPECT_FALSE(now_.grid == before_.grid);
  EXPECT_GT(now_.statistics.kept_thetas, now_.statistics.counts.functions / 2);
  EXPECT_LT(now_.statistics.kept_thetas, now_.statistics.counts.functions);
}

TEST_F(KeptFunctions, WhatChangesFarFromASupportIsSeen) {
  expectWholeBakesBytes(seeBothSides);
  EXPECT_FALSE(now_.grid == before_.grid);
}

TEST_F(KeptFunctions, NothingIsMadeAnewWhereNothingHasChanged) {
  EXPECT_TRUE(before_.grid == bakeHouse(leaveAsItIs, nullptr).grid) << "keeping changes nothing";
  const size_t kept = kept_.size();
  for (const Change& change : {Change(leaveAsItIs), Change(reorder)}) {
    expectWholeBakesBytes(change);
    EXPECT_EQ(now_.statistics.kept_thetas, now_.statistics.counts.functions);
    EXPECT_EQ(kept_.size(), kept);
  }
  // what a bake says of its functions it says of kept ones
  const BakeStatistics &before = before_.statistics, &now = now_.statistics;
  EXPECT_EQ(now.refined(), before.refined());
  EXPECT_GT(now.refined(), 0u);
  EXPECT_EQ(now.failing(ThetaWord::stored, {}), before.failing(ThetaWord::stored, {}));
}

class KeptFile : public KeptFunctions {
 protected:
  KeptThetas read(const nlohmann::ordered_json& origin) { return readKept(path_, origin, representations(), &told_); }
  void write(const std::string& bytes) { writeFileAtomically(path_, bytes); }

  std::string path_ = (std::filesystem::temp_directory_path() / ("kept_" + std::to_string(::getpid()))).string(), told_;
  const nlohmann::ordered_json origin_ = {{"revision", "a"}, {"options", {{"adam_steps", 20}}}};
  void TearDown() override { std::filesystem::remove(path_); }
};

TEST_F(KeptFile, IsRefusedWhereItIsDamagedOrSomethingElse) {
  const std::string whole = keptBytes(kept_, origin_);
  const auto said = [&](const std::string& bytes) {
    write(bytes);
    const std::string error = errorOfCall<DamageError>([&] { read(origin_); });
    return error == "no error" ? "" : error;
  };
  expectDamageIsRefused(whole, said, whole.size() / 20);
  write(before_.grid);
  EXPECT_THROW(read(origin_), InputError);
  EXPECT_TRUE(before_.grid == readFile(path_));
}

}  // namespace
}  // namespace nlg
