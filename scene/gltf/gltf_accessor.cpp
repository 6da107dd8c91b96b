#include "scene/gltf/gltf_accessor.h"

#include <algorithm>
#include <cstring>

#include "tool/error.h"

namespace nlg {
namespace {

// 0: it is no unsigned integer.
int unsignedBytes(int component_type) {
  const bool is_unsigned = component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  return is_unsigned ? tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(component_type)) : 0;
}

}  // namespace

bool isSmallInteger(int component_type) {
  return component_type >= TINYGLTF_COMPONENT_TYPE_BYTE && component_type <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
}

float componentAt(const unsigned char* bytes, int component_type, bool is_normalized) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_FLOAT) {
    float value = 0.0f;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  const bool is_byte = component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  const int byte_count = is_byte ? 1 : 2;
  const bool is_signed = component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_SHORT;
  const int range = 1 << (8 * byte_count);
  int value = static_cast<int>(readUnsigned(bytes, byte_count));
  if (is_signed && value >= range / 2) value -= range;
  if (!is_normalized) return static_cast<float>(value);
  return std::max(static_cast<float>(value) / static_cast<float>(is_signed ? range / 2 - 1 : range - 1), -1.0f);
}

std::vector<float> readNumbers(const tinygltf::Model& model, int accessor_idx, int least, int width,
                               const std::vector<uint32_t>* which, uint64_t count, const std::string& path,
                               const std::string& place, SceneBudgets& budgets) {
  requireIndex(accessor_idx, model.accessors.size(), path, place, "an accessor");
  const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(accessor_idx)];
  const int type = accessor.componentType;
  const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
  const bool is_known = type == TINYGLTF_COMPONENT_TYPE_FLOAT || isSmallInteger(type);
  if (!is_known || components < least || components > width)
    throw InputError(
        path, place,
        "elements of " + std::to_string(least) + " to " + std::to_string(width) + " floats or integers of 8 or 16 bits",
        "component type " + std::to_string(type) + ", type " + std::to_string(accessor.type));
  const AccessorReader elements(model, accessor_idx, path, place, budgets);
  if (elements.count() < count)
    throw InputError(path, place, std::to_string(count) + " elements", std::to_string(elements.count()));
  const size_t read_count = which == nullptr ? count : which->size();
  budgets.accessor_elements.take(read_count, path, place);
  const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type));
  std::vector<float> numbers(read_count * static_cast<size_t>(width), 1.0f);
  for (size_t i = 0; i < read_count; ++i) {
    const unsigned char* bytes = elements.element(which == nullptr ? i : (*which)[i]);
    for (int k = 0; k < components; ++k)
      numbers[i * static_cast<size_t>(width) + static_cast<size_t>(k)] =
          bytes == nullptr ? 0.0f : componentAt(bytes + k * component_bytes, type, accessor.normalized);
  }
  return numbers;
}

uint32_t readUnsigned(const unsigned char* bytes, int byte_count) {
  uint32_t value = 0;
  for (int i = 0; i < byte_count; ++i) value |= static_cast<uint32_t>(bytes[i]) << (8 * i);
  return value;
}

void requireIndex(int idx, size_t count, const std::string& path, const std::string& place, const std::string& what) {
  if (idx >= 0 && static_cast<size_t>(idx) < count) return;
  throw InputError(path, place, what + " below " + std::to_string(count), std::to_string(idx));
}

std::span<const unsigned char> bytesOfView(const tinygltf::Model& model, int view_idx, const std::string& path,
                                           const std::string& place) {
  requireIndex(view_idx, model.bufferViews.size(), path, place, "a bufferView");
  const tinygltf::BufferView& view = model.bufferViews[static_cast<size_t>(view_idx)];
  requireIndex(view.buffer, model.buffers.size(), path, place, "a buffer");
  const std::vector<unsigned char>& data = model.buffers[static_cast<size_t>(view.buffer)].data;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset) {
    throw InputError(path, place,
                     "buffer view " + std::to_string(view_idx) + " within the buffer's " + std::to_string(data.size()) + " bytes",
                     std::to_string(view.byteLength) + " bytes at " + std::to_string(view.byteOffset));
  }
  return std::span(data).subspan(view.byteOffset, view.byteLength);
}

AccessorReader::AccessorReader(const tinygltf::Model& model, int accessor_idx, const std::string& path, const std::string& place,
                               SceneBudgets& budgets)
    : model_(model), path_(path), place_(place) {
  const tinygltf::Accessor& accessor = model.accessors[accessor_idx];
  count_ = accessor.count;
  const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
  const int component_count = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
  if (component_bytes <= 0 || component_count <= 0) fail("a known type", std::to_string(accessor.componentType));
  const auto element_bytes = static_cast<uint64_t>(component_bytes) * static_cast<uint64_t>(component_count);
  if (accessor.bufferView >= 0) {
    elements_ = checkedSpan(accessor.bufferView, accessor.byteOffset, element_bytes, count_, "elements");
  } else {
    // nothing in the file bounds their count
    budgets.accessor_zeros.take(count_, path, place);
  }
  if (accessor.sparse.isSparse) readSparse(accessor, element_bytes, budgets);
}

void AccessorReader::fail(const std::string& expected, const std::string& got) const {
  throw InputError(path_, place_, expected, got);
}

AccessorReader::Span AccessorReader::checkedSpan(int view_idx, uint64_t offset, uint64_t element_bytes, uint64_t count,
                                                 const std::string& what) const {
  const std::span<const unsigned char> bytes = bytesOfView(model_, view_idx, path_, place_);
  const size_t view_stride = model_.bufferViews[static_cast<size_t>(view_idx)].byteStride;
  const uint64_t stride = view_stride == 0 ? element_bytes : view_stride;
  if (stride < element_bytes) fail("a stride of " + std::to_string(element_bytes) + " or more", std::to_string(stride));
  // no sum or product below can overflow: offset and count are first bounded by what the view holds
  const bool starts_inside = offset <= bytes.size() && element_bytes <= bytes.size() - offset;
  const bool fits = count == 0 || (starts_inside && count - 1 <= (bytes.size() - offset - element_bytes) / stride);
  if (!fits) {
    fail(what + " within the " + std::to_string(bytes.size()) + " bytes of buffer view " + std::to_string(view_idx),
         std::to_string(count) + " of " + std::to_string(element_bytes) + " bytes at offset " + std::to_string(offset));
  }
  return {bytes.data() + (count == 0 ? 0 : offset), stride};
}

void AccessorReader::readSparse(const tinygltf::Accessor& accessor, uint64_t element_bytes, SceneBudgets& budgets) {
  const auto& sparse = accessor.sparse;
  sparse_index_bytes_ = unsignedBytes(sparse.indices.componentType);
  if (sparse_index_bytes_ == 0) fail("sparse indices of 8, 16 or 32 bits", std::to_string(sparse.indices.componentType));
  if (sparse.count < 0 || static_cast<uint64_t>(sparse.count) > count_) {
    fail("at most " + std::to_string(count_) + " sparse elements", std::to_string(sparse.count));
  }
  sparse_count_ = static_cast<uint64_t>(sparse.count);
  const auto offset = [](int bytes) { return static_cast<uint64_t>(bytes < 0 ? 0 : bytes); };
  sparse_indices_ = checkedSpan(sparse.indices.bufferView, offset(sparse.indices.byteOffset),
                                static_cast<uint64_t>(sparse_index_bytes_), sparse_count_, "sparse indices");
  sparse_values_ =
      checkedSpan(sparse.values.bufferView, offset(sparse.values.byteOffset), element_bytes, sparse_count_, "sparse values");
  budgets.accessor_elements.take(sparse_count_, path_, place_);
  for (uint64_t i = 0; i < sparse_count_; ++i) {
    const uint64_t idx = sparseIndex(i);
    if (idx >= count_) fail("sparse indices below " + std::to_string(count_), std::to_string(idx));
    if (i > 0 && idx <= sparseIndex(i - 1)) fail("rising sparse indices", std::to_string(idx));
  }
}

uint64_t AccessorReader::sparseIndex(uint64_t idx) const {
  return readUnsigned(sparse_indices_.data + idx * sparse_indices_.stride, sparse_index_bytes_);
}

const unsigned char* AccessorReader::element(uint64_t idx) const {
  uint64_t low = 0;
  uint64_t high = sparse_count_;
  while (low < high) {
    const uint64_t middle = (low + high) / 2;
    if (sparseIndex(middle) < idx) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  if (low < sparse_count_ && sparseIndex(low) == idx) return sparse_values_.data + low * sparse_values_.stride;
  return elements_.data == nullptr ? nullptr : elements_.data + idx * elements_.stride;
}

}  // namespace nlg
