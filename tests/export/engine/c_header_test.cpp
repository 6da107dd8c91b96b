#include "export/shader/shader_export.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cfenv>
#include <cmath>
#include <cstring>

#include "nlg/look_up.h"
#include "nlg/nlg.h"
#include "nlg/shader_grid.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "tests/damage.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"

extern "C" int cHeaderIrradiance(const uint8_t* bytes, size_t size, const float* position_m, const float* normal, float* rgb);
extern "C" int cHeaderIsWhole(const uint8_t* bytes, size_t size);

namespace nlg {
namespace {

std::string gridBytes(const LightGrid& grid) {
  ShaderGrid packed;
  EXPECT_TRUE(packShaderGrid(grid, &packed).ok());
  return shaderGridBytes(packed);
}

// Bytes that end where memory ends: a read beyond them ends the test.
class FencedBytes {
 public:
  explicit FencedBytes(std::string_view bytes) : size_(bytes.size()) {
    const auto page = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
    const size_t pages = (size_ + page - 1) / page * page;
    mapped_bytes_ = pages + page;
    mapped_ = static_cast<uint8_t*>(::mmap(nullptr, mapped_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    EXPECT_EQ(::mprotect(mapped_ + pages, page, PROT_NONE), 0);
    first_ = mapped_ + pages - size_;
    std::memcpy(first_, bytes.data(), size_);
  }
  ~FencedBytes() { ::munmap(mapped_, mapped_bytes_); }
  FencedBytes(const FencedBytes&) = delete;
  FencedBytes& operator=(const FencedBytes&) = delete;

  LightStatus lookUp(const PositionM& position_m, const std::array<float, 3>& normal, float* rgb) const {
    const float position[3] = {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]),
                               static_cast<float>(position_m[2])};
    return static_cast<LightStatus>(cHeaderIrradiance(first_, size_, position, normal.data(), rgb));
  }
  bool isWhole() const { return cHeaderIsWhole(first_, size_) != 0; }
  uint8_t* data() { return first_; }
  size_t size() const { return size_; }

 private:
  size_t size_, mapped_bytes_;
  uint8_t *mapped_, *first_;
};

class CHeaderPrecision : public testing::TestWithParam<ThetaPrecision> {};

TEST_P(CHeaderPrecision, SaysWhatTheLookUpSays) {
  const LightGrid grid = everyRepresentation(GetParam(), 3);
  const FencedBytes bytes(gridBytes(grid));
  Random random(5);
  std::array<int, 4> count{};
  for (int i = 0; i < 20000; ++i) {
    const PositionM at = randomPlace(grid.tree.frame(), random);
    const std::array<float, 3> normal = randomNormal(random);
    float exact[3], rgb[3];
    const LightStatus status = lookUpIrradiance(grid, at, normal.data(), exact);
    ASSERT_EQ(bytes.lookUp(at, normal, rgb), status) << at[0] << ' ' << at[1] << ' ' << at[2];
    ++count[static_cast<size_t>(status)];
    // as the shader's test has it
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], exact[c], 1e-3f * std::max(1.0f, exact[c])) << i;
  }
  for (const LightStatus status : {LightStatus::lit, LightStatus::faint, LightStatus::outside})
    EXPECT_GT(count[static_cast<size_t>(status)], 20) << lightStatusName(status);
}

// Light of three groups, by the colours that stand in the head.
TEST_P(CHeaderPrecision, SaysWhatAMixOfGroupsSays) {
  LightGrid grid = everyRepresentation(GetParam(), 13);
  for (uint64_t g = 0; g < 3; ++g)
    grid.groups.push_back({"group " + std::to_string(g), randomLight(grid.tree.probeCount(), 20 + g)});
  roundGridLight(kLightError, &grid);
  FencedBytes bytes(gridBytes(grid));
  EXPECT_TRUE(bytes.isWhole());
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  const std::vector<std::array<float, 3>> colours = {{1.0f, 0.5f, 0.25f}, {0.0f, 0.0f, 0.0f}, {0.5f, 2.0f, 1.0f}};
  ASSERT_TRUE(mixLight(colours, &grid).ok());
  for (size_t g = 0; g < 3; ++g)
    std::memcpy(bytes.data() + 16 * (static_cast<size_t>(packed.first_colour) + g), colours[g].data(), sizeof colours[g]);
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    const PositionM at = randomPlace(grid.tree.frame(), random);
    const std::array<float, 3> normal = randomNormal(random);
    float exact[3], rgb[3];
    const LightStatus status = lookUpIrradiance(grid, at, normal.data(), exact);
    ASSERT_EQ(bytes.lookUp(at, normal, rgb), status) << at[0] << ' ' << at[1] << ' ' << at[2];
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], exact[c], 1e-3f * std::max(1.0f, exact[c])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, CHeaderPrecision, testing::Values(ThetaPrecision::int8, ThetaPrecision::float16),
                         [](const auto& precision) { return std::string(thetaPrecisionName(precision.param)); });

// Engines may trap overflow, invalid operations and division by zero: no look-up raises them, by any processor's instructions.
TEST(CHeader, AndTheLibraryRaiseNoFloatingPointException) {
  LightGrid grid = everyRepresentation(ThetaPrecision::float16, 3);
  // logits far beyond what exp bears
  for (size_t f = 0; f < grid.functionCount(); ++f) {
    if (grid.representations[grid.function_representation[f]].isCode()) continue;
    for (uint64_t t = grid.theta_begin[f]; t < grid.theta_begin[f + 1]; ++t)
      grid.theta[t] = std::clamp(50.0f * grid.theta[t], -6e4f, 6e4f);
  }
  const FencedBytes bytes(gridBytes(grid));
  ShaderPlaces places = randomPlaces(grid, 3000, 17);
  for (const double odd : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, -1e30, 1e11, -1e11}) {
    for (size_t axis = 0; axis < 6; ++axis) {
      places.positions_m.push_back(grid.tree.probePosition(0));
      places.normals.push_back({0.0f, 0.0f, 1.0f});
      if (axis < 3) places.positions_m.back()[axis] = odd;
      if (axis >= 3) places.normals.back()[axis - 3] = static_cast<float>(odd);
    }
  }
  std::string file;
  ASSERT_TRUE(serializeLightGrid(grid, {}, {}, &file).ok());
  nlg_light_grid* c_grid = nullptr;
  ASSERT_EQ(nlg_light_grid_load_bytes(file.data(), file.size(), &c_grid, nullptr, 0), NLG_OK);
  std::vector<float> normals, rgb(3 * places.positions_m.size());
  for (const std::array<float, 3>& normal : places.normals) normals.insert(normals.end(), normal.begin(), normal.end());
  std::vector<LightStatus> status(places.positions_m.size());
  forEachTarget([&] {
    LookUpScratch scratch;
    nlg_look_up_scratch* c_scratch = nullptr;
    ASSERT_EQ(nlg_look_up_scratch_create(&c_scratch), NLG_OK);
    std::feclearexcept(FE_ALL_EXCEPT);
    for (size_t i = 0; i < places.positions_m.size(); ++i) {
      ProbeWeights weights;
      lookUpWeights(grid, places.positions_m[i], &weights);
      lookUpIrradiance(grid, places.positions_m[i], &normals[3 * i], rgb.data());
      bytes.lookUp(places.positions_m[i], places.normals[i], rgb.data());
      nlg_irradiance(c_grid, places.positions_m[i].data(), &normals[3 * i], rgb.data());
    }
    const PositionM farthest{1.7e308, -1.7e308, 0.0};
    lookUpIrradiance(grid, farthest, normals.data(), rgb.data());
    nlg_irradiances(c_grid, places.positions_m[0].data(), normals.data(), places.positions_m.size(), rgb.data(),
                    reinterpret_cast<uint8_t*>(status.data()), c_scratch);
    lookUpIrradiances(grid, places.positions_m.data(), normals.data(), places.positions_m.size(), rgb.data(), status.data(),
                      &scratch);
    EXPECT_EQ(std::fetestexcept(FE_OVERFLOW), 0);
    EXPECT_EQ(std::fetestexcept(FE_INVALID), 0);
    EXPECT_EQ(std::fetestexcept(FE_DIVBYZERO), 0);
    nlg_look_up_scratch_free(c_scratch);
  });
  nlg_light_grid_free(c_grid);
}

TEST(CHeader, IsDarkWhereAPositionOrANormalIsNoNumber) {
  const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 4);
  const FencedBytes bytes(gridBytes(grid));
  const PositionM inside = grid.tree.probePosition(0);
  float rgb[3];
  for (const double broken : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, -1e30}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      PositionM at = inside;
      at[axis] = broken;
      EXPECT_EQ(bytes.lookUp(at, {0.0f, 0.0f, 1.0f}, rgb), LightStatus::outside);
      for (const float channel : rgb) EXPECT_EQ(channel, 0.0f);
      std::array<float, 3> normal{};
      normal[axis] = static_cast<float>(broken);
      EXPECT_EQ(bytes.lookUp(inside, normal, rgb), LightStatus::unlit);
      for (const float channel : rgb) EXPECT_EQ(channel, 0.0f);
    }
  }
}

// Whatever the bytes say, and however few they are.
TEST(CHeader, ReadsNothingOutsideOfItsBytes) {
  const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 4);
  const std::string whole = gridBytes(grid);
  Random random(7);
  float rgb[3];
  for (int round = 0; round < 300; ++round) {
    FencedBytes bytes(
        std::string_view(whole).substr(0, round < 100 ? static_cast<size_t>(round) : random.below(whole.size() + 1)));
    // the head, where everything else is found by, and anything
    for (int i = 0; i < 20 && bytes.size() > 0 && round % 2 == 0; ++i)
      bytes.data()[random.below(static_cast<uint32_t>(i < 10 ? std::min<size_t>(bytes.size(), 256) : bytes.size()))] =
          static_cast<uint8_t>(random.next());
    for (int i = 0; i < 50; ++i) bytes.lookUp(randomPosition(grid.tree.frame(), random), {0.0f, 1.0f, 0.0f}, rgb);
  }
}

TEST(CHeader, KnowsWhatIsDamaged) {
  const std::string whole = gridBytes(everyRepresentation(ThetaPrecision::int8, 4));
  // an odd step comes by every place of the last byte in its block of 64
  expectDamageIsRefused(
      whole, [](const std::string& bytes) { return FencedBytes(bytes).isWhole() ? "" : "damaged"; }, whole.size() / 6 | 1);
}

}  // namespace
}  // namespace nlg
