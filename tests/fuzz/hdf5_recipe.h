// Hostile HDF5 files for fuzz targets: written anew by HDF5 itself for every input.
//
// HDF5 keeps a checksum over every block of its own: a mutated file ends there, and hardly ever reaches a reader of ours. So an
// input is a recipe: a list of edits to a file that is right, after which HDF5 writes it, with the digest that belongs to it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {

enum class ElementKind : uint8_t { u8, u32, i32, u64, f32, f64, text, big_endian };
inline constexpr int kElementKinds = 8;

inline ElementKind kindOf(uint8_t) { return ElementKind::u8; }
inline ElementKind kindOf(uint32_t) { return ElementKind::u32; }
inline ElementKind kindOf(int32_t) { return ElementKind::i32; }
inline ElementKind kindOf(uint64_t) { return ElementKind::u64; }
inline ElementKind kindOf(float) { return ElementKind::f32; }
inline ElementKind kindOf(double) { return ElementKind::f64; }

// An array; without a shape an attribute of one value.
struct Hdf5Item {
  std::string name;
  ElementKind kind = ElementKind::u8;
  std::vector<uint64_t> shape;
  std::string bytes;
};

template <class T>
Hdf5Item arrayItem(const std::string& name, const std::vector<uint64_t>& shape, const std::vector<T>& values) {
  return {name, kindOf(T{}), shape, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T))};
}
template <class T>
Hdf5Item attributeItem(const std::string& name, T value) {
  return {name, kindOf(value), {}, std::string(reinterpret_cast<const char*>(&value), sizeof value)};
}
inline Hdf5Item textItem(const std::string& name, const std::string& text) { return {name, ElementKind::text, {}, text}; }

// Writes a file of these items after the recipe's edits. An input that begins like an HDF5 file is one, and is taken as it stands.
void writeRecipe(const std::vector<Hdf5Item>& items, std::string_view recipe, const ScratchFile& file);

// Recipes to start from: no edit, and one of every kind.
Seeds recipeSeeds();

}  // namespace nlg::fuzz
