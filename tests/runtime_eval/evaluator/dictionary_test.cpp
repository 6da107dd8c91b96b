
#include <gtest/gtest.h>

#include "runtime_eval/evaluator/evaluate.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_fields.h"

namespace nlg {
namespace {

constexpr int kResolutions[] = {3, 5, 7, 9};

// A code at the ends of a byte in places, and whole numbers between them.
Theta wideCode(int count, uint64_t seed) {
  Random random(seed);
  Theta z;
  for (int k = 0; k < count; ++k) {
    const int whole = k % 5 == 0 ? kMostCodeSteps : static_cast<int>(random.below(2 * kMostCodeSteps + 1)) - kMostCodeSteps;
    z.push_back(static_cast<float>(random.below(2) == 0 ? whole : -whole));
  }
  return z;
}

// The logit at a node of the first numbers of a code: products are exact, and each is added with one rounding, in the order of k. In
// double a sum of two floats whose exponents are less than 29 apart is exact, so that it is rounded once, to float.
float logitInOrder(const DictionaryData& data, const Theta& z, int length, int node) {
  const int nodes = data.resolution * data.resolution * data.resolution;
  const auto numberOf = [&](int row) {
    return std::ldexp(static_cast<double>(data.nodes[static_cast<size_t>(row * nodes + node)]),
                      data.exponents[static_cast<size_t>(row)]);
  };
  auto sum = static_cast<float>(numberOf(data.code_count));
  for (int k = 0; k < length; ++k) sum = static_cast<float>(double{sum} + double{z[static_cast<size_t>(k)]} * numberOf(k));
  return sum;
}

double largestOf(const AlignedFloats& values) {
  double largest = 0.0;
  for (const float value : values) largest = std::max(largest, std::fabs(static_cast<double>(value)));
  return largest;
}

// How far float arithmetic may take tent sigmoid(L) from the formula: as fieldError of sample_fields.h has it for B.
double brickError(int resolution, double largest) {
  const double inside = (3 + 6) * 8 * largest, anywhere = 3 * (2.0 * (resolution - 1)) * 2 * largest + 9 * 2 * largest;
  return kFloatRounding * std::max(inside, anywhere) / 4 + 10 * kFloatRounding;
}

struct Case {
  SharedDictionary dictionary;
  Theta z;
  AlignedFloats logits;  // rounded
  double bound = 0.0;
};

Case makeCase(int resolution, int count, uint64_t seed) {
  Case made{sampleDictionary(resolution, count, seed), wideCode(count, seed + 1), {}};
  made.logits.resize(made.dictionary->nodeStride());
  roundedLogits(*made.dictionary, made.z.data(), made.logits.data());
  made.bound = brickError(resolution, largestOf(made.logits));
  return made;
}

// Rows whose sums a float must round: of exponents up to 13 apart, and a step of 2^3.
DictionaryData roundingData(int resolution, int count) {
  DictionaryData data = sampleDictionaryData(resolution, count, 3);
  for (int k = 0; k <= count; ++k) data.exponents[k] = static_cast<int8_t>(-4 - 7 * k % 14);
  return data;
}

TEST(ExpandCode, GivesTheSameBitsOnEveryTarget) {
  for (const int resolution : kResolutions) {
    for (const int count : {8, 16, 48, 128}) {
      const Dictionary dictionary(roundingData(resolution, count));
      Theta z = wideCode(count, 4);
      for (float& number : z) number *= 8.0f;
      forEachTarget([&] {
        for (const int length : {0, 1, count / 2, count - 1, count}) {
          AlignedFloats logits(dictionary.nodeStride(), NAN);
          expandCode(dictionary, z.data(), length, logits.data());
          for (int n = 0; n < dictionary.nodeCount(); ++n) {
            ASSERT_EQ(logits[n], logitInOrder(dictionary.data(), z, length, n))
                << resolution << "³, " << length << " of " << count << ", node " << n;
          }
          for (size_t n = dictionary.nodeCount(); n < logits.size(); ++n) ASSERT_EQ(logits[n], 0.0f) << "behind, " << n;
        }
      });
    }
  }
}

TEST(Brick, GivesTheSameBitsAsItsCode) {
  for (const int resolution : kResolutions) {
    const Case made = makeCase(resolution, 32, 6);
    std::vector<int8_t> brick(static_cast<size_t>(made.dictionary->nodeCount()));
    std::vector<uint32_t> quads(quadCount(resolution));
    const float step = packBrick(*made.dictionary, made.z.data(), brick.data());
    packQuads(resolution, brick.data(), quads.data());
    for (const LocalPoint& point : testPoints(300)) {
      // a step is a power of two: whether it is a factor of the nodes or of their blend changes no bit
      ASSERT_EQ(evaluateQuads(resolution, point, step, quads.data()), evaluateCode(*made.dictionary, point, made.z.data()));
    }
  }
}

TEST(Code, EqualsTheReferenceInEveryCellOnEveryTarget) {
  for (const int resolution : kResolutions) {
    const PointOrder& order = cellOrder(resolution);
    const Case made = makeCase(resolution, 48, 7);
    const std::vector<double> exact = toDouble(made.z);
    std::vector<double> expected;
    for (int place = 0; place < order.placeCount(); place += 7) {
      expected.push_back(evaluateCodeReference(*made.dictionary, placePosition(order, place), exact.data()));
    }
    forEachTarget([&] {
      AlignedFloats values(order.placeCount());
      evaluateLogitCells(order, made.logits.data(), values.data());
      for (int place = 0; place < order.placeCount(); place += 7) {
        ASSERT_NEAR(values[place], expected[static_cast<size_t>(place / 7)], made.bound) << resolution << "³, place " << place;
      }
    });
  }
}

TEST(Code, EqualsTheReferenceAtAnyPointsOnEveryTarget) {
  for (const int resolution : kResolutions) {
    const Case made = makeCase(resolution, 16, 8);
    const Representation code = Representation::code(made.dictionary);
    const std::vector<double> exact = toDouble(made.z);
    for (const int count : {1, 15, 16, 17, 129}) {
      std::vector<LocalPoint> list = testPoints(count);
      list.push_back({1.0f, -1.0f, 1.0f});
      list.push_back({0.0f, 0.0f, 0.0f});
      const PointSet points = makePointSet(list);
      forEachTarget([&] {
        AlignedFloats values(points.padded_count + 16, 7.0f);
        evaluate(code, points, made.z.data(), values.data());
        for (size_t i = 0; i < list.size(); ++i) {
          const double expected = evaluateReference(code, list[i], exact.data());
          ASSERT_NEAR(values[i], expected, made.bound) << resolution << "³, point " << i << " of " << count;
          ASSERT_NEAR(evaluatePoint(code, list[i], made.z.data()), expected, made.bound) << resolution << "³, point " << i;
        }
        for (int i = 0; i < 16; ++i) ASSERT_EQ(values[points.padded_count + i], 7.0f) << "written behind the points";
      });
    }
  }
}

// Logits of any size are in range; a place that is no number reads nothing outside the brick.
TEST(Code, StaysBetween0AndTheTentWhateverTheCode) {
  const SharedDictionary dictionary = sampleDictionary(9, 16, 10);
  const Representation code = Representation::code(dictionary);
  const PointSet points = makePointSet(testPoints(257));
  forEachTarget([&] {
    for (const float size : {0.0f, 1e-42f, 1e3f, -1e3f, 1e30f, -1e30f}) {
      const Theta z(16, size);
      AlignedFloats values(points.padded_count);
      evaluate(code, points, z.data(), values.data());
      for (int i = 0; i < points.count; ++i) {
        ASSERT_GE(values[i], 0.0f) << size;
        ASSERT_LE(values[i], points.tent[i] * (1 + 4 * kFloatRounding)) << size;
      }
    }
  });
  const Theta z(16, 20.0f);
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    std::vector<int8_t> brick(9 * 9 * 9);
    std::vector<uint32_t> quads(quadCount(9));
    const float step = packBrick(*dictionary, z.data(), brick.data());
    packQuads(9, brick.data(), quads.data());
    for (int axis = 0; axis < 3; ++axis) {
      LocalPoint point = {0.1f, 0.2f, 0.3f};
      point[static_cast<size_t>(axis)] = bad;
      const float value = evaluateQuads(9, point, step, quads.data());
      EXPECT_TRUE(std::isnan(bad) ? std::isnan(value) : value >= 0.0f && value <= 1.0f) << bad;
    }
  }
}

}  // namespace
}  // namespace nlg
