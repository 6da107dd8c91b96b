#include "render/place_picture.h"

#include <gtest/gtest.h>

#include "render/picture/legend.h"
#include "tests/render/rendered.h"

namespace nlg {
namespace {

MeasuredPlace darkPlace(float answer) {
  return {"even", {{0.3, 0.2, -1.0}, {0, 0, 1}}, glm::vec3(0.0f), glm::vec3(answer), 1.0, answer};
}

PlacePictureOptions smallPlacePicture() {
  PlacePictureOptions options;
  options.width = 48;
  options.height = 32;
  options.truth_rays = 8;
  options.thread_count = 1;
  return options;
}

// Of 4 x 2.5 x 6 m, without any light.
const Rendered& darkRoom() {
  static const Rendered dark(room(glm::vec3(0.5f), glm::vec3(0.0f)));
  return dark;
}

int countOf(const Image& image, Colour colour) {
  int count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) count += image.at(x, y) == colour;
  }
  return count;
}

TEST(PlacePicture, ViewStandsInTheOpenOnTheNormalsSide) {
  for (const Receiver& place : {Receiver{{0, 0, 0}, {0, 1, 0}}, Receiver{{0.5, -0.95, 2}, {0, 1, 0}},
                                Receiver{{1.97, 0.3, -1}, {-1, 0, 0}}, Receiver{{0, 1.48, 0}, {0, -1, 0}}}) {
    const PlaceView view = viewOfPlace(darkRoom().transport, place);
    const glm::dvec3 back = view.camera.eye_m - place.position_m;
    EXPECT_GT(glm::dot(back, glm::dvec3(place.normal)), 0.0);
    EXPECT_LE(glm::length(back), 3.0 + 1e-9);
    EXPECT_GT(glm::length(back), 1.0) << "the room has space for more";
    EXPECT_FALSE(darkRoom().rays.isBlocked(glm::vec3(place.position_m), glm::vec3(view.camera.eye_m)));
    EXPECT_NEAR(glm::dot(glm::normalize(back), glm::dvec3(view.camera.forward)), -1.0, 1e-6);
    EXPECT_GT(view.camera.up.y, 0.0f);
    EXPECT_EQ(view.ball.centre_m, place.position_m);
  }
}

// Three pictures of 48 x 32: truth is black, the answer is not; needles cover less than half of each.
TEST(PlacePicture, LeakIsBrightBesideBlackTruthAndRedInTheError) {
  const Image leaks = drawPlace(darkRoom().transport, darkPlace(3.0f), even(glm::vec3(3.0f)), smallPlacePicture());
  EXPECT_GT(countOf(leaks, kBlack), 48 * 32 / 2);
  EXPECT_LE(countOf(leaks, kBlack), 48 * 32);
  EXPECT_GT(countOf(leaks, diverging(1.0)), 48 * 32 / 2);
  const Image right = drawPlace(darkRoom().transport, darkPlace(3.0f), even(glm::vec3(0.0f)), smallPlacePicture());
  EXPECT_GT(countOf(right, kBlack), 2 * 48 * 32 / 2);
  EXPECT_EQ(countOf(right, diverging(1.0)), 0);
}

}  // namespace
}  // namespace nlg
