// Bounds-checked access to the elements of a glTF accessor.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "scene/archive/scene_file.h"

namespace nlg {

// throws   InputError at this place where an index is not below a count; what: "a mesh"
void requireIndex(int idx, size_t count, const std::string& path, const std::string& place, const std::string& what);

// The bytes of a buffer view.
// throws   InputError at this place where it is none, or not within its buffer
std::span<const unsigned char> bytesOfView(const tinygltf::Model& model, int view_idx, const std::string& path,
                                           const std::string& place);

// The elements of one accessor, still in the file's bytes. Every element below count() can be read: the constructor has checked
// buffer view, offset, stride and length, and a sparse accessor's indices.
class AccessorReader {
 public:
  // budgets   of elements: zeros and sparse values are taken from them here, whatever else is read by the caller
  // throws    InputError at this place
  AccessorReader(const tinygltf::Model& model, int accessor_idx, const std::string& path, const std::string& place,
                 SceneBudgets& budgets);

  uint64_t count() const { return count_; }
  // The element's bytes; null stands for zeros, as an accessor without a buffer view holds.
  const unsigned char* element(uint64_t idx) const;

 private:
  struct Span {
    const unsigned char* data = nullptr;
    uint64_t stride = 0;
  };
  Span checkedSpan(int view_idx, uint64_t offset, uint64_t element_bytes, uint64_t count, const std::string& what) const;
  void readSparse(const tinygltf::Accessor& accessor, uint64_t element_bytes, SceneBudgets& budgets);
  uint64_t sparseIndex(uint64_t idx) const;
  [[noreturn]] void fail(const std::string& expected, const std::string& got) const;

  const tinygltf::Model& model_;
  const std::string& path_;
  const std::string& place_;
  uint64_t count_ = 0;
  Span elements_;
  Span sparse_indices_, sparse_values_;
  uint64_t sparse_count_ = 0;
  int sparse_index_bytes_ = 0;
};

// What KHR_mesh_quantization lets positions be beside floats.
bool isSmallInteger(int component_type);
// A float, or an integer of 8 or 16 bits as it is or normalized by glTF's formulas: the largest is 1, the smallest signed one no less
// than -1.
float componentAt(const unsigned char* bytes, int component_type, bool is_normalized);

// Elements of an accessor as such numbers.
//
// width   numbers that each element becomes: those that it lacks are 1; at least `least` it must have
// which   elements, in this order; null: the first count
// count   of elements that there must be
// returns   width numbers for each, not all of them finite
// throws  InputError at this place on other components, and on what the accessor's reader refuses
std::vector<float> readNumbers(const tinygltf::Model& model, int accessor_idx, int least, int width,
                               const std::vector<uint32_t>* which, uint64_t count, const std::string& path,
                               const std::string& place, SceneBudgets& budgets);

// A little-endian unsigned integer of 1, 2 or 4 bytes.
uint32_t readUnsigned(const unsigned char* bytes, int byte_count);

}  // namespace nlg
