// Radiance and irradiance of a picture by pixel, and the error of one method's picture against another's.
#pragma once

#include <string>
#include <vector>

#include "light/methods/light_method.h"
#include "render/sight.h"

namespace nlg {

struct LitPicture {
  std::string method;
  int width = 0, height = 0;
  // by pixel, row by row from the top
  std::vector<glm::vec3> radiance;    // the mean of its samples: albedo x irradiance / pi + shine
  std::vector<glm::vec3> irradiance;  // the mean of its receivers
  std::vector<glm::vec3> deviation;   // of the irradiance's noise
  std::vector<float> receiver_share;  // of its samples; 0: nothing is lit there
  std::vector<uint8_t> in_solid;      // of a cut: 1 where no sample is in air
  double unlit_share = 0.0;           // of all receivers: where the method knows no light
};

// What arrives at every sample's receiver; samples without one are unlit. The same bits for any number of threads.
std::vector<LightAnswer> lightSamples(const Sights& sights, const LightAt& light_at, int thread_count);

// received   by sample
LitPicture pictureOf(const Sights& sights, const std::string& method, const std::vector<LightAnswer>& received);

// Both.
LitPicture lightPicture(const Sights& sights, const std::string& method, const LightAt& light_at, int thread_count);

// Over pixels that have receivers, all channels, of irradiance. In shares of the root mean square of truth's; 0 where truth is 0.
struct PictureError {
  double rmse = 0.0;
  double bias = 0.0;         // mean of method less truth
  double truth_noise = 0.0;  // root mean square of truth's standard deviation: an rmse below it says nothing
};
PictureError pictureError(const LitPicture& picture, const LitPicture& truth);

// Root mean square of irradiance over pixels that have receivers, all channels.
double irradianceRms(const LitPicture& picture);

double luminanceOf(const glm::vec3& rgb);

// Of an even number of values the upper one; 0 of none.
double medianOf(std::vector<double> values);

}  // namespace nlg
