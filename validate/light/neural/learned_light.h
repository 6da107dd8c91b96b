// What a method that learns a scene's light leaves behind, and what it cost.
#pragma once

#include <cstddef>
#include <functional>

#include "light/methods/light_method.h"

namespace nlg {

// Words are of 32 bits; a look-up's own inputs and its places on a tree's way down are not among them.
struct LearnedCost {
  size_t parameters = 0;      // numbers that are stored
  size_t multiply_adds = 0;   // of a look-up
  size_t words_by_place = 0;  // that it reads from where its place says: scattered over memory
  size_t words_shared = 0;    // that every look-up reads
  size_t networks = 0;        // 0 of a tree
  size_t places = 0;          // that were learned from, held-out ones not among them
  size_t steps = 0;           // of training, over all networks
  size_t clamped = 0;         // numbers beyond float16
  double training_s = 0.0;    // processor seconds, threads summed
};

struct LearnedLight {
  std::function<LightAnswer(const glm::dvec3& position_m, const glm::vec3& normal)> irradiance_at;  // owns what it reads
  MethodBytes bytes;
  LearnedCost cost;
};

// Bytes of a number in every network and table, and how many are a word.
inline constexpr size_t kLearnedBytes = 2, kLearnedInWord = 2;

}  // namespace nlg
