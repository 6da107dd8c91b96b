#include "validate/views/view_figures.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"
#include "tests/validate/light/lit_scenes.h"
#include "validate/views/view_truth.h"

namespace nlg {
namespace {

// A floor seen from straight above, 4 x 2 m at 4 cm a pixel, of one grey.
const ViewSurfaces kFloor = [] {
  ViewSurfaces surfaces;
  surfaces.sights.width = 100;
  surfaces.sights.height = 50;
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 100; ++x) {
      Sight sight;
      sight.kind = Sight::Kind::receiver;
      sight.receiver = {{0.04 * x, 0.0, 0.04 * y}, {0.0f, 1.0f, 0.0f}};
      sight.albedo = glm::vec3(0.5f);
      surfaces.sights.samples.push_back(sight);
      // all, and edges in the left half
      surfaces.classes.push_back(x < 50 ? 0b11 : 0b1);
    }
  }
  return surfaces;
}();

std::vector<LightAnswer> evenLight(float irradiance, float deviation = 0.0f) {
  return std::vector<LightAnswer>(kFloor.classes.size(), {glm::vec3(irradiance), Reach::lit, glm::vec3(deviation)});
}

std::vector<LightAnswer> scaled(std::vector<LightAnswer> light, float factor) {
  for (LightAnswer& at : light) at.irradiance *= factor;
  return light;
}

const ViewFigures& of(const ViewFiguresByClass& figures, ViewClass of_class) { return figures[static_cast<size_t>(of_class)]; }

ViewFigures allOf(const ViewTruth& truth, const std::vector<LightAnswer>& answers) {
  return of(viewFigures(kFloor, truth, answers), ViewClass::all);
}

TEST(ViewFigures, AreZeroOfTruthItself) {
  std::vector<LightAnswer> light = evenLight(1.0f);
  // any light, from bright to black
  for (size_t i = 0; i < light.size(); ++i) light[i].irradiance *= static_cast<float>(i % 7) * static_cast<float>(i % 11);
  const ViewTruth truth = truthOf(kFloor, light, 0.0, 1);
  for (const ViewFigures& f : viewFigures(kFloor, truth, light)) {
    for (const double figure : {f.colour, f.off.brighter, f.off.darker, f.below_eighth, f.ringing}) EXPECT_EQ(figure, 0.0);
    EXPECT_EQ(f.energy, 1.0);
  }
}

TEST(ViewFigures, OfTwiceTheLightAreWhatTheySay) {
  const std::vector<LightAnswer> light = evenLight(3.0f);
  const ViewTruth truth = truthOf(kFloor, light, 0.0, 1);
  const ViewFigures twice = allOf(truth, scaled(light, 2.0f));
  EXPECT_EQ(twice.receivers, kFloor.classes.size());
  EXPECT_EQ(twice.off.brighter, 0.0) << "twice is not more than twice";
  EXPECT_EQ(twice.off.darker, 0.0);
  EXPECT_NEAR(twice.energy, 2.0, 1e-6);
  // .18 and .36 of white: L* 49.50 and 66.52
  EXPECT_NEAR(twice.colour, 66.52 - 49.50, 0.05);
  const ViewFigures third = allOf(truth, scaled(light, 1.0f / 3.0f));
  EXPECT_EQ(third.off.darker, 1.0);
  EXPECT_EQ(third.off.brighter, 0.0);
  EXPECT_EQ(third.ringing, 1.0);
}

TEST(ViewFigures, TakeNoisyTruthForOffOnlyBeyondItsNoise) {
  const std::vector<LightAnswer> light = evenLight(1.0f, 0.2f);
  const ViewTruth truth = truthOf(kFloor, light, 0.0, 1);
  EXPECT_NEAR(truth.noise, 0.2, 1e-6);
  // truth may be 1.2, and 2 times that is 2.4
  EXPECT_EQ(allOf(truth, scaled(light, 2.35f)).off.brighter, 0.0);
  EXPECT_EQ(allOf(truth, scaled(light, 2.45f)).off.brighter, 1.0);
}

// A quarter of the picture has less than an eighth; truth's noise of .2 makes it a tenth of the light.
TEST(ViewFigures, CountAsBlackSpotsWhatHasLessThanAnEighthOfTheLight) {
  for (const auto& [deviation, limit] : {std::pair(0.0f, 0.125f), {0.2f, 0.1f}}) {
    const std::vector<LightAnswer> light = evenLight(1.0f, deviation);
    const ViewTruth truth = truthOf(kFloor, light, 0.0, 1);
    std::vector<LightAnswer> answers = scaled(light, 1.01f * limit);
    EXPECT_EQ(allOf(truth, answers).below_eighth, 0.0);
    for (size_t i = 0; i < answers.size(); i += 4) answers[i].irradiance *= 0.98f;
    EXPECT_EQ(allOf(truth, answers).below_eighth, 0.25);
  }
}

// Of a scene whose brightest view has 10: the eye adapts to .01 here, and a hundredth of that is black.
TEST(ViewFigures, OfAViewWithoutLightAreOfWhatTheDarkestEyeWouldSee) {
  const std::vector<LightAnswer> dark = evenLight(0.0f);
  const ViewTruth truth = truthOf(kFloor, dark, 10.0, 1);
  EXPECT_EQ(truth.median, 0.0);
  EXPECT_TRUE(truth.isKnown());
  EXPECT_FALSE(truth.isCounted()) << "a hollow that no light reaches is no picture";
  const auto leaking = [&](float light) { return allOf(truth, evenLight(light)); };
  EXPECT_EQ(leaking(0.9e-4f).off.brighter, 0.0);
  EXPECT_EQ(leaking(1.1e-4f).off.brighter, 1.0);
  // shown as middle grey, L* 49.50
  EXPECT_NEAR(leaking(0.01f).colour, 49.50, 0.05);
  // nothing changes where there is more
  const std::vector<LightAnswer> light = evenLight(0.02f);
  EXPECT_EQ(truthOf(kFloor, light, 10.0, 1).exposure, truthOf(kFloor, light, 0.0, 1).exposure);
  EXPECT_TRUE(truthOf(kFloor, light, 10.0, 1).isCounted());
}

// At 1/3 three deviations are as much as the light, and twice of it is not told from it.
TEST(ViewFigures, AreOfNoUseWhereTruthIsNotKnown) {
  const auto isKnown = [&](float deviation) {
    const std::vector<LightAnswer> light = evenLight(1.0f, deviation);
    return truthOf(kFloor, light, 1.0, 1).isKnown();
  };
  EXPECT_TRUE(isKnown(0.33f));
  EXPECT_FALSE(isKnown(0.34f));
}

TEST(ViewFigures, FindRingsWhereTheyAreAndNowhereElse) {
  // truth: bright, and dark on a strip of 8 cm at x = 2 m
  std::vector<LightAnswer> light = evenLight(1.0f);
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % 100 == 50 || i % 100 == 51) light[i].irradiance = glm::vec3(0.3f);
  }
  const ViewTruth truth = truthOf(kFloor, light, 0.0, 3);
  // the answer: dark at x = .4 m, where truth is bright all around, and at 2.2 m, which is 16 cm from the strip
  std::vector<LightAnswer> answer = light;
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % 100 == 10 || i % 100 == 55) answer[i].irradiance = glm::vec3(0.5f);
  }
  const ViewFiguresByClass figures = viewFigures(kFloor, truth, answer);
  EXPECT_NEAR(of(figures, ViewClass::all).ringing, 0.01, 1e-9);
  EXPECT_NEAR(of(figures, ViewClass::edge).ringing, 0.02, 1e-9) << "all of it in the left half, which is the class";
  // a third darker is no ring yet
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % 100 == 10) answer[i].irradiance = glm::vec3(0.67f);
  }
  EXPECT_EQ(allOf(truth, answer).ringing, 0.0);
}

TEST(ViewFigures, OfSeveralViewsCountEachViewAndEachReceiverOfAClass) {
  std::vector<ViewFiguresByClass> views(2);
  views[0][0].receivers = 1000, views[0][0].colour = 2.0;
  views[1][0].receivers = 500, views[1][0].colour = 4.0;
  const auto edge = static_cast<size_t>(ViewClass::edge);
  views[0][edge].receivers = 10, views[0][edge].off.brighter = 1.0;
  views[1][edge].receivers = 30;
  const ViewFiguresByClass mean = meanFigures(views);
  EXPECT_EQ(mean[0].colour, 3.0);
  EXPECT_EQ(mean[0].receivers, 1500u);
  EXPECT_EQ(mean[edge].off.brighter, 0.25);
  EXPECT_EQ(mean[static_cast<size_t>(ViewClass::figure)].receivers, 0u);
}

class ViewTruthFile : public testing::Test {
 protected:
  void SetUp() override {
    options_.gather.rays = 8;
    options_.scene_sha256 = "a scene";
    sights_ = surfacesOf(lit_.transport, {0, cameraAlong({-1, 1, 1.5}, {1, 0, 0}, 1.2), {}}, 16, 9, 1).sights;
  }

  TracedView truth() const { return viewTruth(lit_.transport, sights_, options_, path()); }
  std::string path() const { return folder_ / "view.truth.safetensors"; }

  const LitScene lit_{furnace()};
  ViewTruthOptions options_;
  Sights sights_;
  const TemporaryFolder folder_;
};

TEST_F(ViewTruthFile, HoldsWhatWasTraced) {
  const TracedView traced = truth(), read = truth();
  EXPECT_FALSE(traced.was_read);
  EXPECT_TRUE(read.was_read);
  EXPECT_EQ(traced.rounds, read.rounds);
  ASSERT_EQ(traced.at.size(), read.at.size());
  for (size_t i = 0; i < traced.at.size(); ++i) {
    EXPECT_EQ(traced.at[i].irradiance, read.at[i].irradiance);
    EXPECT_EQ(traced.at[i].deviation, read.at[i].deviation);
  }
}

TEST_F(ViewTruthFile, IsMadeAnewWhereAnythingThatDecidesItIsOther) {
  const auto isOther = [&](const auto& change) {
    truth();
    const ViewTruthOptions kept = options_;
    const Sights sights = sights_;
    change();
    const bool was_read = truth().was_read;
    options_ = kept;
    sights_ = sights;
    return !was_read;
  };
  EXPECT_FALSE(isOther([] {}));
  EXPECT_TRUE(isOther([&] { options_.scene_sha256 = "another scene"; }));
  EXPECT_TRUE(isOther([&] { options_.gather.rays = 16; }));
  EXPECT_TRUE(isOther([&] { options_.gather.direct = DirectLight::no_suns; }));
  EXPECT_TRUE(isOther([&] { options_.noise = 0.2; }));
  EXPECT_TRUE(isOther([&] { options_.seed = 2; }));
  EXPECT_TRUE(isOther([&] { sights_.samples[3].receiver.position_m.x += 1e-9; }));
}

// Half of the floor is lit by a thousandth of the other's light: whatever is wrong with it there, nobody sees it.
TEST(ViewFigures, DoNotLookIntoTheBlack) {
  std::vector<LightAnswer> light = evenLight(1.0f), answer = light;
  for (size_t i = 0; i < light.size(); i += 3) {
    light[i].irradiance = glm::vec3(0.001f);
    answer[i].irradiance = glm::vec3(0.009f);
  }
  const ViewTruth truth = truthOf(kFloor, light, 0.0, 1);
  EXPECT_EQ(allOf(truth, answer).off.brighter, 0.0);
  for (size_t i = 0; i < light.size(); i += 3) answer[i].irradiance = glm::vec3(0.011f);
  EXPECT_NEAR(allOf(truth, answer).off.brighter, 1.0 / 3.0, 1e-3);
}

TEST(ColourDifference, IsThatOfLab) {
  EXPECT_EQ(hyAb(labOf(glm::vec3(0.3f)), labOf(glm::vec3(0.3f))), 0.0f);
  EXPECT_NEAR(hyAb(labOf(glm::vec3(0.0f)), labOf(glm::vec3(1.0f))), 100.0f, 1e-2f);
  EXPECT_EQ(labOf(glm::vec3(2.0f)), labOf(glm::vec3(1.0f))) << "a display shows no more than white";
  // sRGB's red: L* 53.24, a* 80.09, b* 67.20
  const glm::vec3 red = labOf({1.0f, 0.0f, 0.0f});
  EXPECT_NEAR(red.x, 53.24f, 0.02f);
  EXPECT_NEAR(red.y, 80.09f, 0.05f);
  EXPECT_NEAR(red.z, 67.20f, 0.05f);
}

}  // namespace
}  // namespace nlg
