#include <gtest/gtest.h>

#include <algorithm>

#include "light/directions.h"
#include "light/methods/apv.h"
#include "light/methods/weightings.h"
#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

class BaselinesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    lit_ = new LitScene(brightAndDarkRoom());
    probes_ = new ProbeSet(makeProbeSet(lit_->tree, lit_->transport, {{256, 64}, 1, 1}));
  }
  static void TearDownTestSuite() {
    delete probes_;
    delete lit_;
  }
  static LitScene* lit_;
  static ProbeSet* probes_;
};
LitScene* BaselinesTest::lit_ = nullptr;
ProbeSet* BaselinesTest::probes_ = nullptr;

TEST_F(BaselinesTest, ApvCapturesLightOutsideOfAWall) {
  ProbeSet probes = *probes_;
  const auto nearest = [&](const glm::dvec3& to) {
    size_t best = 0;
    for (size_t p = 1; p < probes.count(); ++p) {
      if (glm::distance(probes.position_m[p], to) < glm::distance(probes.position_m[best], to)) best = p;
    }
    return best;
  };
  // 2 cm behind the face of the bright room: its light is captured before that face
  const size_t moved = nearest({-1.0, 1.5, 1.5});
  probes.position_m[moved] = {kWallLow + 0.02, 1.5, 1.5};
  const ApvProbes baked = bakeApvProbes(probes, lit_->transport, {{256, 64}, 1, 1});
  EXPECT_TRUE(baked.is_valid[moved]);
  // the room's own light, radiance 1 all round: .282 times 4 pi
  EXPECT_NEAR(baked.light[moved][0].r, 3.545f, 0.1f);
}

TEST(Apv, TakesLightForProbesDeepInSolidFromThoseAround) {
  Scene scene = furnace();
  // the block in the room is dark, inside and out
  std::fill(scene.light.baked.vertex_light.end() - 36, scene.light.baked.vertex_light.end(), glm::vec3(0.0f));
  const LitScene lit(std::move(scene));
  ProbeSet probes = makeProbeSet(lit.tree, lit.transport, {{256, 64}, 1, 1});
  const glm::dvec3 middle(-0.3, -0.35,
                          0.15);  // .4 m and more from the block's faces: a virtual offset looks no further than .2 m
  ProbesAround around;
  ASSERT_TRUE(lit.tree.lookUp({middle.x, middle.y, middle.z}, &around));
  const uint32_t deep = around.corners[0].probe;
  const glm::dvec3 was = probes.position_m[deep];
  probes.position_m[deep] = middle;
  const ApvProbes baked = bakeApvProbes(probes, lit.transport, {{256, 64}, 1, 1});
  EXPECT_FALSE(baked.is_valid[deep]);
  EXPECT_GT(baked.light[deep][0].r, 1.0f) << "its own is 0";
  const Apv apv(probes, baked);
  const ProbeBlend blend = apv.blendAt(was + glm::dvec3(0.01), {0, 1, 0});
  EXPECT_EQ(blend.reach, Reach::lit);
  EXPECT_EQ(std::count(blend.probe.begin(), blend.probe.begin() + blend.count, deep), 0);
}

// What a place's probes weigh in all is lost in shares, and decides how much a solve trusts the place.
TEST_F(BaselinesTest, TargetFunctionsHandOverWhatTheirWeightsAddUpTo) {
  std::vector<glm::dvec3> places;
  for (const LightPlace& place : lit_->places().places) places.push_back(place.position_m);
  const TargetFunctions functions(places, *probes_, lit_->rays, {}, 1);
  const std::vector<TrueWeights> truth = trueWeights(places, lit_->tree, lit_->rays, {}, 1);
  int below_one = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const ProbeWeights weights = functions.weightsAt(places[i], {0, 1, 0});
    const ProbeBlend blend = functions.blendAt(places[i], {0, 1, 0});
    ASSERT_EQ(weights.count, blend.count);
    double sum = 0.0;
    for (int j = 0; j < weights.count; ++j) {
      sum += blend.weight[j];
      const auto corner = std::find(truth[i].probe.begin(), truth[i].probe.end(), weights.probe[j]) - truth[i].probe.begin();
      ASSERT_LT(corner, kCornerCount);
      // a division and a product of single precision
      EXPECT_NEAR(weights.weight[j], truth[i].target[corner], 3e-7 * truth[i].target[corner]);
    }
    if (weights.count == 0) continue;
    EXPECT_NEAR(sum, 1.0, 1e-6);
    below_one += blend.sum < 0.9f;
  }
  EXPECT_GT(below_one, 10) << "beside the wall half of the probes are not seen";
}

TEST(Baselines, AreMadeByTheirNamesOnCommandLinesOnce) {
  const LitScene lit(brightAndDarkRoom());
  MethodSet methods = lit.methods();
  for (const MethodSet::Baseline& baseline : MethodSet::baselines()) EXPECT_TRUE(MethodSet::isBaseline(baseline.name));
  EXPECT_FALSE(MethodSet::isBaseline("truth"));
  // as shipped alone, by its short name and by its whole one
  methods.addNamed("ddgi");
  methods.addNamed("ddgi-as-shipped");
  ASSERT_EQ(methods.methods().size(), 1u);
  EXPECT_EQ(methods.named("ddgi"), &methods.methods()[0]);
  EXPECT_EQ(methods.named("ddgi"), methods.named("ddgi-as-shipped"));
  EXPECT_EQ(methods.named("apv"), nullptr);
  methods.addNamed("valid-trilinear:solved");
  methods.addNamed("valid-trilinear");
  ASSERT_EQ(methods.methods().size(), 3u);
  EXPECT_EQ(methods.named("valid-trilinear:solved")->light, "solved");
  EXPECT_EQ(methods.named("valid-trilinear")->light, "point");
}

TEST(Baselines, AnswerManyReceiversAsTheyAnswerOne) {
  const LitScene lit(brightAndDarkRoom());
  MethodSet methods = lit.methods();
  for (const MethodSet::Baseline& baseline : MethodSet::baselines()) (methods.*baseline.add)({LightWay::point});
  std::vector<Receiver> receivers;
  const LightPlaces places = lit.places();
  // more than are asked for at once
  for (int n = 0; n < 4; ++n) {
    for (const LightPlace& place : places.places) receivers.push_back({place.position_m, place.normal});
  }
  ASSERT_GE(methods.methods().size(), MethodSet::baselines().size());
  for (const LightMethod& method : methods.methods()) {
    const std::vector<LightAnswer> answers = answersAt(method.light_at, receivers, 3);
    ASSERT_EQ(answers.size(), receivers.size());
    size_t lit_count = 0;
    for (size_t i = 0; i < receivers.size(); ++i) {
      const LightAnswer one = answerAt(method.light_at, receivers[i]);
      ASSERT_EQ(answers[i].irradiance, one.irradiance) << method.weights << ' ' << i;
      ASSERT_EQ(answers[i].reach, one.reach) << method.weights << ' ' << i;
      lit_count += one.isLit();
    }
    EXPECT_GT(lit_count, receivers.size() / 2) << method.weights;
  }
}

}  // namespace
}  // namespace nlg
