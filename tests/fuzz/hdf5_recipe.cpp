#include "tests/fuzz/hdf5_recipe.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "datagen/dataset/hdf5_detail.h"
#include "datagen/functions/chunk_codec.h"
#include "tool/atomic_file.h"

namespace nlg::fuzz {
namespace {

using hdf5::Handle;

constexpr size_t kMaxItemBytes = size_t{1} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 26;

enum class Edit : uint8_t { drop, kind, extent, rank, value, storage, raw_chunk, other_object, repeat };
constexpr int kEdits = 9;

// How an item lies in the file, beside what it is.
struct Placed : Hdf5Item {
  enum class Object : uint8_t { item, group, soft_link, external_link, no_value };
  static constexpr int kObjects = 5;
  Object object = Object::item;
  bool is_dropped = false, is_chunked = true, is_deflated = true, is_summed = true, is_shuffled = false;
  uint64_t chunk_rows = 32;
  bool has_raw_chunk = false;
  std::string raw_chunk;
  uint32_t skipped_filters = 0;
};

// Takes a recipe apart; zeros behind its end.
class RecipeBytes {
 public:
  explicit RecipeBytes(std::string_view bytes) : bytes_(bytes) {}
  bool done() const { return bytes_.empty(); }
  uint64_t number(size_t byte_count) {
    uint64_t value = 0;
    const size_t count = std::min(byte_count, bytes_.size());
    std::memcpy(&value, bytes_.data(), count);
    bytes_.remove_prefix(count);
    return value;
  }
  size_t below(size_t limit) { return number(1) % limit; }
  std::string_view text() {
    const size_t count = std::min<size_t>(number(1), bytes_.size());
    const std::string_view text = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return text;
  }
  // Small ones, those near powers of two, and whatever the bytes say.
  uint64_t extent() {
    const uint64_t choice = number(1);
    if (choice < 64) return choice;
    if (choice < 192) return (uint64_t{1} << choice % 64) + choice / 64 - 2;
    return number(choice % 8 + 1);
  }

 private:
  std::string_view bytes_;
};

hid_t fileType(ElementKind kind) {
  const hid_t types[kElementKinds] = {H5T_STD_U8LE,   H5T_STD_U32LE,  H5T_STD_I32LE, H5T_STD_U64LE,
                                      H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_C_S1,      H5T_STD_U64BE};
  return types[static_cast<size_t>(kind)];
}

void applyEdit(RecipeBytes& bytes, std::vector<Placed>& items) {
  const auto edit = static_cast<Edit>(bytes.below(kEdits));
  Placed& item = items[bytes.below(items.size())];
  switch (edit) {
    case Edit::drop:
      item.is_dropped = true;
      break;
    case Edit::kind:
      item.kind = static_cast<ElementKind>(bytes.below(kElementKinds));
      break;
    case Edit::extent:
      if (!item.shape.empty()) item.shape[bytes.below(item.shape.size())] = bytes.extent();
      break;
    case Edit::rank:
      item.shape.resize(bytes.below(6), bytes.extent());
      break;
    case Edit::value: {
      const size_t at = bytes.number(2) % (item.bytes.size() + 1);
      const std::string_view text = bytes.text();
      item.bytes.replace(at, item.kind == ElementKind::text ? item.bytes.npos : text.size(), text);
      break;
    }
    case Edit::storage: {
      const uint64_t bits = bytes.number(1);
      item.is_chunked = (bits & 1) != 0, item.is_deflated = (bits & 2) != 0, item.is_summed = (bits & 4) != 0,
      item.is_shuffled = (bits & 8) != 0;
      item.chunk_rows = bytes.extent();
      break;
    }
    case Edit::raw_chunk: {
      item.has_raw_chunk = true;
      const uint64_t bits = bytes.number(1);
      item.skipped_filters = static_cast<uint32_t>(bits >> 2);
      item.raw_chunk = std::string(bytes.text());
      if ((bits & 1) != 0) {
        const auto* data = reinterpret_cast<const uint8_t*>(item.raw_chunk.data());
        const std::vector<uint8_t> encoded = encodeChunk(data, item.raw_chunk.size());
        item.raw_chunk.assign(encoded.begin(), encoded.end());
      } else if ((bits & 2) != 0) {
        const uint32_t sum = fletcher32(reinterpret_cast<const uint8_t*>(item.raw_chunk.data()), item.raw_chunk.size());
        item.raw_chunk.append(reinterpret_cast<const char*>(&sum), sizeof sum);
      }
      break;
    }
    case Edit::other_object:
      item.object = static_cast<Placed::Object>(bytes.below(Placed::kObjects));
      break;
    case Edit::repeat:
      if (item.bytes.size() < kMaxItemBytes) item.bytes.append(item.bytes);
      break;
  }
}

// Whatever HDF5 refuses to write is left out: the reader meets what is there.
void writeAttribute(hid_t file, const Placed& item) {
  const Handle type(H5Tcopy(fileType(item.kind)), H5Tclose);
  if (item.kind == ElementKind::text) H5Tset_size(type, std::max<size_t>(item.bytes.size(), 1));
  const Handle space(item.object == Placed::Object::no_value ? H5Screate(H5S_NULL) : H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, item.name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  std::string bytes = item.bytes;
  bytes.resize(std::max<size_t>(bytes.size(), 8));
  if (attribute.ok() && item.object == Placed::Object::item) H5Awrite(attribute, type, bytes.data());
}

void writeArray(hid_t file, const Placed& item) {
  const Handle type(H5Tcopy(fileType(item.kind)), H5Tclose);
  const std::vector<hsize_t> dims(item.shape.begin(), item.shape.end());
  const Handle space(item.object == Placed::Object::no_value
                         ? H5Screate(H5S_NULL)
                         : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                     H5Sclose);
  uint64_t count = 1;
  bool is_large = false;
  for (const uint64_t extent : item.shape)
    is_large = is_large || __builtin_mul_overflow(count, extent, &count) || count > kMaxItemBytes / 8;
  if (std::find(item.shape.begin(), item.shape.end(), 0u) != item.shape.end()) count = 0, is_large = false;
  // only chunks may be missing: anything else would take its place in the file
  const bool is_chunked = item.is_chunked && !dims.empty() && (count > 0 || is_large);
  if (is_large && !is_chunked) return;
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  if (is_chunked) {
    std::vector<hsize_t> chunk = dims;
    chunk[0] = std::max<uint64_t>(std::min<uint64_t>(item.chunk_rows, chunk[0]), 1);
    // HDF5 keeps eight bytes a chunk in memory, and writes them, even where none is there
    if (dims[0] / chunk[0] > kMaxItemBytes / 8) return;
    H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (item.is_shuffled) H5Pset_shuffle(properties);
    if (item.is_deflated) H5Pset_deflate(properties, 1);
    if (item.is_summed) H5Pset_fletcher32(properties);
  }
  const Handle dataset(H5Dcreate2(file, item.name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
  if (!dataset.ok() || item.object == Placed::Object::no_value) return;
  if (!is_large) {
    std::string bytes = item.bytes;
    bytes.resize(std::max<size_t>(bytes.size(), count * std::max<size_t>(H5Tget_size(type), 1)));
    H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
  }
  if (!item.has_raw_chunk || !is_chunked) return;
  const std::vector<hsize_t> first(dims.size(), 0);
  H5Dwrite_chunk(dataset, H5P_DEFAULT, item.skipped_filters, first.data(), item.raw_chunk.size(), item.raw_chunk.data());
}

void writeItem(hid_t file, const Placed& item) {
  switch (item.object) {
    case Placed::Object::group:
      H5Gclose(H5Gcreate2(file, item.name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      return;
    case Placed::Object::soft_link:
      H5Lcreate_soft("/flags", file, item.name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    case Placed::Object::external_link:
      H5Lcreate_external("elsewhere.h5", "/phi", file, item.name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    default:
      break;
  }
  if (item.shape.empty()) return writeAttribute(file, item);
  writeArray(file, item);
}

// As Hdf5Writer::closeWithDigest leaves it: the file's own SHA-256, with these bytes taken as zeros.
haddr_t makeDigestArray(hid_t file) {
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY);
  const hsize_t size = hdf5::kDigestBytes;
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Handle dataset(H5Dcreate2(file, hdf5::kDigestName, H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
  return dataset.ok() ? H5Dget_offset(dataset) : HADDR_UNDEF;
}

}  // namespace

void writeRecipe(const std::vector<Hdf5Item>& items, std::string_view recipe, const ScratchFile& file) {
  if (recipe.starts_with("\x89HDF")) return file.write(recipe);
  hdf5::silenceHdf5();
  std::vector<Placed> placed;
  for (const Hdf5Item& item : items) placed.push_back({item});
  for (RecipeBytes bytes(recipe); !bytes.done();) applyEdit(bytes, placed);

  haddr_t digest_first = HADDR_UNDEF;
  {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    H5Pset_file_locking(access, false, true);
    const Handle hdf5(H5Fcreate(file.path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
    FUZZ_CHECK(hdf5.ok(), hdf5::innermostError());
    for (const Placed& item : placed) {
      if (!item.is_dropped) writeItem(hdf5, item);
    }
    digest_first = makeDigestArray(hdf5);
  }
  // HDF5 gives a chunk without filters its whole place in the file, however few bytes are written: gigabytes, which take long to
  // digest, or more than a file can have
  const uint64_t file_bytes = std::filesystem::file_size(file.path());
  if (file_bytes > kMaxFileBytes) return file.write("");
  if (digest_first == HADDR_UNDEF || digest_first + hdf5::kDigestBytes > file_bytes) return;
  const std::vector<uint8_t> digest = fileSha256Bytes(file.path(), {digest_first, hdf5::kDigestBytes});
  file.overwrite(digest_first, {reinterpret_cast<const char*>(digest.data()), digest.size()});
}

Seeds recipeSeeds() {
  Seeds seeds = {{"right", ""}};
  for (int edit = 0; edit < kEdits; ++edit) {
    for (int item = 0; item < 24; item += 3)
      seeds.emplace_back("edit_" + std::to_string(edit) + "_" + std::to_string(item),
                         std::string{static_cast<char>(edit), static_cast<char>(item), 1, 2, 3, 'a', 'b', 'c'});
  }
  return seeds;
}

}  // namespace nlg::fuzz
