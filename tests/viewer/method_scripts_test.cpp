#include "viewer/data_script.h"

#include <gtest/gtest.h>

#include "light/methods/weightings.h"
#include "nlg/look_up.h"
#include "runtime_eval/numbers/half.h"
#include "runtime_eval/numbers/random.h"
#include "tests/validate/light/lit_scenes.h"
#include "tool/base64.h"

namespace nlg {
namespace {

std::vector<LightSh> randomLight(size_t count) {
  Random random(1);
  std::vector<LightSh> light(count);
  for (LightSh& sh : light) {
    sh[0] = glm::vec3(random.uniform(1.0, 2.0), random.uniform(1.0, 2.0), random.uniform(1.0, 2.0));
    for (size_t i = 1; i < sh.size(); ++i)
      sh[i] = glm::vec3(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
  }
  return light;
}

// The page shows trilinear probes as a light grid without functions: it has to be the same method.
TEST(TrilinearGrid, LightsAsTheTrilinearMethodDoes) {
  const LitScene lit(brightAndDarkRoom());
  ProbeSet probes = makeProbeSet(lit.tree, lit.transport, {{8, 1}, 1, 1});
  // as if whole rows of them stood in solid
  for (size_t p = 0; p < probes.count(); ++p) probes.is_in_air[p] = p / 16 % 3 != 0;
  const std::vector<LightSh> light = randomLight(probes.count());
  for (const TrilinearKind kind : {TrilinearKind::all, TrilinearKind::valid}) {
    const Trilinear trilinear(kind, probes, lit.rays);
    const LightAt light_at = blendedLight(trilinear, light);
    const LightGrid grid = trilinearGrid(probes, light, kind == TrilinearKind::all);
    ASSERT_TRUE(checkLightGrid(grid).ok());
    Random random(2);
    int lit_count = 0;
    for (int i = 0; i < 4000; ++i) {
      const glm::dvec3 at(random.uniform(-4.0, 4.0), random.uniform(-1.0, 3.0), random.uniform(-4.0, 4.0));
      const glm::vec3 normal =
          glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) + glm::vec3(1e-3f));
      ProbesAround around;
      if (!grid.tree.lookUp({at.x, at.y, at.z}, &around)) continue;
      const LightAnswer answer = answerAt(light_at, {at, normal});
      glm::vec3 rgb;
      lookUpIrradiance(grid, {at.x, at.y, at.z}, &normal.x, &rgb.x);
      lit_count += answer.irradiance.r > 0.0f;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], answer.irradiance[c], 1e-4f) << at.x << ' ' << at.y << ' ' << at.z;
    }
    EXPECT_GT(lit_count, 500);
  }
}

// Array `maps` of a script, read as the page reads it.
std::vector<uint32_t> wordsOf(const std::string& text, const std::string& array) {
  const size_t facts = text.find('{'), end = text.rfind("}, \"");
  const auto json = nlohmann::json::parse(text.substr(facts, end + 1 - facts));
  const size_t first = json["arrays"][array][1], count = json["arrays"][array][2];
  const size_t text_begin = end + 4;
  std::string bytes;
  EXPECT_TRUE(fromBase64(text.substr(text_begin, text.rfind('"') - text_begin), &bytes));
  std::vector<uint32_t> words(count);
  std::memcpy(words.data(), &bytes.at(first), count * sizeof(uint32_t));
  return words;
}

TEST(DdgiScript, HoldsTheMapsAsTheyAreShipped) {
  const LitScene lit(brightAndDarkRoom());
  const ProbeSet probes = makeProbeSet(lit.tree, lit.transport, {{64, 4}, 1, 1});
  DdgiMapsOptions options;
  options.gather = {256, 4};
  DdgiMaps maps = asShipped(makeDdgiMaps(probes, lit.transport, options));
  for (size_t p = 0; p < maps.probes.size(); p += 3) maps.probes[p].is_active = false;
  const std::vector<uint32_t> words = wordsOf(ddgiScript(probes, maps).text(), "maps");
  ASSERT_EQ(words.size(), kDdgiMapWords * maps.probes.size());
  size_t active = 0;
  for (size_t p = 0; p < maps.probes.size(); ++p) {
    const uint32_t* word = &words[kDdgiMapWords * p];
    ASSERT_EQ(word[0], maps.probes[p].is_active ? 1u : 0u);
    active += word[0];
    for (size_t t = 0; t < 36; ++t) {
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(static_cast<float>(word[1 + t] >> (10 * c) & 1023u) / 1023.0f, maps.probes[p].irradiance.texels[t][c], 1e-6f);
    }
    for (size_t t = 0; t < 196; ++t) {
      const uint32_t pair = word[37 + t];
      ASSERT_EQ(floatFromHalf(Half{static_cast<uint16_t>(pair)}), maps.probes[p].depth.texels[t].x);
      ASSERT_EQ(floatFromHalf(Half{static_cast<uint16_t>(pair >> 16)}), maps.probes[p].depth.texels[t].y);
    }
  }
  EXPECT_GT(active, 10u);
  EXPECT_LT(active, maps.probes.size());
}

}  // namespace
}  // namespace nlg
