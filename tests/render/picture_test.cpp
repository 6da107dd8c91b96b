#include <gtest/gtest.h>

#include "light/standing.h"
#include "render/camera.h"
#include "render/denoise.h"
#include "render/lit_views.h"
#include "render/picture/legend.h"
#include "render/tone.h"
#include "tests/render/rendered.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

SightOptions smallPicture(int samples_per_side = SightOptions().samples_per_side) {
  SightOptions options;
  options.width = 24;
  options.height = 16;
  options.samples_per_side = samples_per_side;
  options.thread_count = 1;
  return options;
}

const Camera kAcross = cameraAlong({-1.5, 0.2, -2.5}, {1, -0.1, 1.6}, 1.2);

// Everything emits e and reflects ρ: what any ray meets shines with e / (1 - ρ).
TEST(LitPicture, FurnaceIsConstant) {
  const glm::vec3 albedo(0.5f, 0.2f, 0.0f), emission(1.0f, 2.0f, 3.0f);
  const Rendered r(room(albedo, emission));
  const LitPicture picture =
      lightPicture(sightsOf(r.transport, kAcross, smallPicture()), "truth", trueLight(r.transport, {256, 64}, 1), 1);
  for (size_t i = 0; i < picture.radiance.size(); ++i) {
    EXPECT_EQ(picture.receiver_share[i], 1.0f);
    for (int c = 0; c < 3; ++c) {
      const float expected = emission[c] / (1.0f - albedo[c]);
      // five standard deviations for each of 1,152 numbers, and the rounding of sums
      EXPECT_NEAR(picture.radiance[i][c], expected, 5.0f * albedo[c] * picture.deviation[i][c] / kPi + 0.003f * expected);
    }
  }
  EXPECT_EQ(picture.unlit_share, 0.0);
}

TEST(LitPicture, SkyIsWhatTheCameraSeesBesideTheGround) {
  Scene scene = SceneOfFaces().addQuad({-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9}).finish();
  scene.light.sky = {glm::vec3(0.5f), glm::vec3(0.5f), glm::vec3(0.5f)};
  const Rendered r(scene);
  const Sights sights = sightsOf(r.transport, cameraAlong({0, 1, 8}, {0, 0, -1}, 1.0), smallPicture());
  const LitPicture picture = lightPicture(sights, "even", even(glm::vec3(2.0f)), 1);
  EXPECT_EQ(picture.receiver_share.front(), 0.0f);
  EXPECT_EQ(picture.radiance.front().r, 0.5f);
  EXPECT_EQ(picture.receiver_share.back(), 1.0f);
  // the ground's default albedo is a half
  EXPECT_NEAR(picture.radiance.back().r, 0.5f * 2.0f / kPi, 1e-6f);
}

TEST(LitPicture, ReceiversStandBeforeSurfacesAndNeverBehindOthers) {
  SceneOfFaces faces;
  faces.addBox({-1, -0.5f, -0.5f}, {1, 0, 0.5f});
  // a lid 4 mm above the box's upper side hides it from receivers 2 cm above
  faces.addQuad({-1, 0.004f, 0.5f}, {0, 0.004f, 0.5f}, {0, 0.004f, -0.5f}, {-1, 0.004f, -0.5f}, Sides::two);
  const Rendered r(faces.finish());
  // so low that rays reach under the lid
  const Sights sights = sightsOf(r.transport, cameraAlong({0.5, 0.01, 0}, {-1, -0.012, 0}, 0.1), smallPicture(1));
  int under = 0, open = 0;
  for (const Sight& sight : sights.samples) {
    const Receiver& receiver = sight.receiver;
    if (sight.kind != Sight::Kind::receiver || receiver.normal.y < 0.5f) continue;
    const bool is_under = receiver.position_m.x < 0.0 && receiver.position_m.y < 0.004;
    EXPECT_NEAR(receiver.position_m.y, is_under ? 0.002 : receiver.position_m.x < 0.0 ? 0.024 : 0.02, 1e-4);
    ++(is_under ? under : open);
  }
  EXPECT_GT(under, 0);
  EXPECT_GT(open, 0);
}

TEST(PictureError, IsInSharesOfTruthsRms) {
  const Rendered r(room(glm::vec3(0.5f), glm::vec3(0.0f)));
  const Sights sights = sightsOf(r.transport, kAcross, smallPicture());
  const LitPicture truth = lightPicture(sights, "truth", even(glm::vec3(2.0f)), 1);
  const LitPicture other = lightPicture(sights, "other", even(glm::vec3(2.5f)), 1);
  const PictureError error = pictureError(other, truth);
  EXPECT_NEAR(error.rmse, 0.25, 1e-6);
  EXPECT_NEAR(error.bias, 0.25, 1e-6);
  EXPECT_EQ(error.truth_noise, 0.0);
  EXPECT_EQ(errorRange({&other}, truth), 0.5);
}

TEST(Tone, MedianBecomesMiddleGreyAndNothingIsCutOffAtOne) {
  const Rendered r(room(glm::vec3(0.5f), glm::vec3(0.0f)));
  const Sights sights = sightsOf(r.transport, kAcross, smallPicture());
  const LitPicture picture = lightPicture(sights, "even", even(glm::vec3(7.0f)), 1);
  const double exposure = automaticExposure(picture);
  EXPECT_NEAR(exposure * 7.0 * 0.5 / kPi, 0.18, 1e-6);
  // sRGB of .18 - .04: 255 * (1.055 * .14^(1 / 2.4) - .055) = 104.6; of 1 - .04, which bends to 1 - .24^2 / .44
  EXPECT_EQ(toneMapped(picture, exposure).at(3, 3), (Colour{105, 105, 105}));
  EXPECT_EQ(toneMapped(picture, exposure / 0.18).at(3, 3), (Colour{240, 240, 240}));
  EXPECT_EQ(toneMapped(picture, 1e9).at(3, 3), kWhite);
}

// By hand from the published formula: 4, 1, 1 loses .04, its peak of 3.96 becomes 1 - .24^2 / 3.44 = .98326, and .30868 of it is white.
// Below .08 what is lost is x - 6.25 x^2.
TEST(Tone, IsTheNeutralCurveOfKhronos) {
  LitPicture picture;
  picture.width = picture.height = 1;
  picture.in_solid = {0};
  picture.radiance = {{4.0f, 1.0f, 1.0f}};
  EXPECT_EQ(toneMapped(picture, 1.0).at(0, 0), (Colour{253, 182, 182}));
  picture.radiance = {{0.04f, 0.04f, 0.54f}};  // .01, .01, .51
  EXPECT_EQ(toneMapped(picture, 1.0).at(0, 0), (Colour{25, 25, 189}));
}

TEST(ChosenView, StandsInAirAndSeesTheRoom) {
  const Rendered r(room(glm::vec3(0.5f), glm::vec3(1.0f)));
  const Camera camera = chooseView(r.transport, 1.0, 1.5, 1);
  EXPECT_TRUE(glm::all(glm::lessThan(glm::abs(camera.eye_m - glm::dvec3(0, 0.25, 0)), glm::dvec3(2, 1.25, 3))));
  // a room of 4 x 6 m is not looked at from before a wall: the way ahead is longer than half of its shorter side
  EXPECT_GT(r.rays.lightHit(glm::vec3(camera.eye_m), camera.forward).distance, 2.0f);
  EXPECT_EQ(chooseView(r.transport, 1.0, 1.5, 1).eye_m, camera.eye_m);
}

// Two surfaces, noise of a half on one and none on the other.
TEST(Denoised, TakesNoiseAwayAndKeepsWhatHasNone) {
  const Rendered r(room(glm::vec3(0.5f), glm::vec3(0.0f)));
  const Sights sights = sightsOf(r.transport, kAcross, smallPicture(1));
  std::vector<LightAnswer> light(sights.samples.size());
  const auto isNoisy = [&](size_t i) { return sights.samples[i].receiver.normal.y > 0.5f; };
  for (size_t i = 0; i < light.size(); ++i) {
    const bool is_odd = (i + i / sights.width) % 2 == 1;
    light[i].irradiance = glm::vec3(isNoisy(i) ? (is_odd ? 1.5f : 0.5f) : (is_odd ? 3.0f : 2.0f));
    light[i].deviation = glm::vec3(isNoisy(i) ? 0.5f : 0.0f);
  }
  const std::vector<LightAnswer> result = denoised(sights, kAcross, light, 1);
  size_t noisy = 0;
  for (size_t i = 0; i < light.size(); ++i) {
    noisy += isNoisy(i);
    // a checkerboard's mean over any even number of pixels is 1; windows are cut at edges, and their middle counts for more
    const float expected = isNoisy(i) ? 1.0f : light[i].irradiance.g;
    EXPECT_NEAR(result[i].irradiance.g, expected, isNoisy(i) ? 0.15f : 1e-5f) << i;
  }
  EXPECT_GT(noisy, 20u);
}

// A method that lights one end of a room alone.
TEST(LitViews, StandAtEyeHeightAndLookAtWhatIsLit) {
  const Rendered r(room(glm::vec3(0.5f), glm::vec3(0.0f)));
  const LightAt one_end = [](std::span<const Receiver> receivers, LightAnswer* answers) {
    for (const Receiver& at : receivers) *answers++ = {glm::vec3(at.position_m.z > 0.0 ? 1.0f : 0.0f), Reach::lit};
  };
  const Bounds bounds = sceneBounds(r.scene);
  const ExtentBox extent{glm::dvec3(bounds.min), glm::dvec3(bounds.max)};
  LitViews views(r.transport, one_end, extent, {1.0, 1.5, 1, 2});
  const double most = views.bestWorth();
  const Camera first = views.takeBest();
  EXPECT_NEAR(first.eye_m.y, -1.0 + kEyeHeightM, 1e-3) << "the floor is at -1";
  EXPECT_GT(first.forward.z, 0.0f);
  EXPECT_LT(views.worthOf(first), 0.5 * most) << "what was seen counts little";
  EXPECT_LE(views.worthOf(cameraAlong({0, 0.5, -1}, {0, 0, -1}, 1.0)), 0.0) << "the dark end";
}

}  // namespace
}  // namespace nlg
