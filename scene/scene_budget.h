// Limits what reading one scene may take, so that a small file cannot exhaust the machine.
//
// Files pack: a byte of an archive holds a thousand, a scan of an image a few bytes that ask for all its pixels again, an accessor
// of glTF as many zeros as it says. Each budget is of a whole scene, however many files and entries it is made of, and far above
// all levels that we know (docs/guide/scenes.md has the largest of each).
#pragma once

#include <cstdint>
#include <string>

#include "tool/error.h"

namespace nlg {

inline constexpr uint64_t kMaxSceneTriangles = uint64_t{1} << 25;  // of a glTF or .obj file, instances counted each
inline constexpr uint64_t kMaxLevelTriangles = uint64_t{1} << 23;  // of a Quake III level, patches cut into triangles
inline constexpr uint64_t kMaxSceneBytes =
    (uint64_t{1} << 32) - 1;                                      // a glTF or .obj file, the files it names, what they unpack to
inline constexpr uint64_t kMaxUnpackedBytes = uint64_t{1} << 30;  // that archives (.pk3, .sh3f) unpack to
inline constexpr uint64_t kMaxImagePixels = uint64_t{1} << 33;    // of textures, times the scans of each behind the 16th
inline constexpr uint64_t kMaxTexels = uint64_t{1} << 26;  // kept of all images: beyond it each is kept smaller, none is refused
inline constexpr uint64_t kLeastScanPixels = 4096;         // as which a smaller scan counts: beginning one takes time, too
inline constexpr uint64_t kMaxAccessorElements = uint64_t{1} << 27;  // that the primitives of glTF read: corners, sparse values
inline constexpr uint64_t kMaxAccessorZeros = uint64_t{1} << 20;     // of these, in accessors without a buffer view

// A scene that asks for more than a budget holds: no part of it that could be left out.
class BudgetError : public InputError {
 public:
  using InputError::InputError;
};

// One of them, as it is spent.
class SceneBudget {
 public:
  // what   its unit, as errors name it: "triangles"
  SceneBudget(const char* what, uint64_t most) : what_(what), most_(most) {}

  // throws   BudgetError naming the budget, what is asked of it so far, and the place, when that is more than there was
  void take(uint64_t amount, const std::string& path, const std::string& place);
  // The same, and nothing is spent: of what may be asked for at most.
  void require(uint64_t amount, const std::string& path, const std::string& place) const;
  uint64_t left() const { return most_ - taken_; }

 private:
  const char* what_;
  uint64_t most_, taken_ = 0;
};

// All of them, whole: what one scene's reader starts with.
struct SceneBudgets {
  SceneBudget triangles{"triangles", kMaxSceneTriangles};
  SceneBudget level_triangles{"triangles of a level", kMaxLevelTriangles};
  SceneBudget bytes{"bytes of files and what they unpack to", kMaxSceneBytes};
  SceneBudget unpacked{"bytes out of archives", kMaxUnpackedBytes};
  SceneBudget pixels{"pixels of textures, times their scans,", kMaxImagePixels};
  SceneBudget accessor_elements{"elements of accessors", kMaxAccessorElements};
  SceneBudget accessor_zeros{"elements of accessors without a buffer view", kMaxAccessorZeros};
};

// All of them in words: what --help of every tool that reads scenes ends with.
std::string sceneBudgets();

}  // namespace nlg
