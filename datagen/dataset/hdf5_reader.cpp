#include <bit>
#include <cmath>
#include <cstring>

#include "datagen/dataset/hdf5_detail.h"
#include "datagen/dataset/hdf5_file.h"
#include "datagen/functions/chunk_codec.h"
#include "tool/atomic_file.h"
#include "tool/input_file.h"

namespace nlg {

using namespace hdf5;

namespace {

constexpr uint64_t kMaxChunkBytes = uint64_t{64} << 20;
constexpr uint64_t kDeflateMaxRatio = 1040;  // deflate cannot expand by more than 1032; some room for its own header

// What one reading call needs to point at the culprit.
struct Place {
  const std::string& path;
  std::string what;
  [[noreturn]] void refuse(const std::string& expected, const std::string& got) const {
    throw InputError(path, what, expected, got);
  }
  [[noreturn]] void refuseDamage(const std::string& expected, const std::string& got) const {
    throw DamageError(path, what, expected, got);
  }
  // For calls of HDF5 that cannot fail on an undamaged file: absent names are asked for beforehand.
  void require(bool good, const std::string& expected) const {
    if (!good) refuseDamage(expected, innermostError());
  }
};

// Older superblocks carry no checksum, and HDF5's readers of them trust what they read: files of ours never have one.
void requireOurSuperblock(const std::string& path) {
  const Place place{path, "byte 0"};
  // HDF5 opens by name, too: it is not let near a pipe
  InputFile file(path);
  char start[9] = {};
  if (file.read(start, sizeof start) != sizeof start || std::memcmp(start, "\x89HDF\r\n\x1a\n", 8) != 0) {
    place.refuseDamage("an HDF5 file", "another kind of file, or a truncated one");
  }
  if (start[8] != 3) place.refuse("an HDF5 superblock of version 3", std::to_string(start[8]));
}

Handle openDataset(hid_t file, const Place& place, const std::string& name) {
  const htri_t exists = H5Lexists(file, name.c_str(), H5P_DEFAULT);
  place.require(exists >= 0, "an array");
  if (exists == 0) place.refuse("an array", "none of that name");
  H5L_info_t link{};
  place.require(H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT) >= 0, "an array");
  // any other link may lead into a file that nobody named
  if (link.type != H5L_TYPE_HARD) place.refuse("an array", "a link to another place");
  Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  place.require(dataset.ok(), "an array");
  return dataset;
}

std::vector<uint64_t> datasetShape(hid_t dataset, const Place& place) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  place.require(space.ok(), "an array with a shape");
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > kMaxDimensions) place.refuse("1 to 4 dimensions", std::to_string(rank));
  std::vector<hsize_t> dims(static_cast<size_t>(rank));
  place.require(H5Sget_simple_extent_dims(space, dims.data(), nullptr) == rank, "an array with a shape");
  return {dims.begin(), dims.end()};
}

// Refuses storage that a writer of ours never makes: other files, plug-in filters, chunks that would not fit in memory.
void requireOurLayout(hid_t dataset, const Place& place, uint64_t element_bytes) {
  // virtual and external data would make the digest of this file say nothing of what is read
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  place.require(properties.ok(), "a storage layout");
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (H5Pget_external_count(properties) != 0 || layout == H5D_VIRTUAL) place.refuse("data in this file", "data in another file");
  // a filter of HDF5 may be a plug-in: code loaded because a file names it
  const int filter_count = H5Pget_nfilters(properties);
  for (int i = 0; i < filter_count; ++i) {
    unsigned flags = 0;
    size_t value_count = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties, i, &flags, &value_count, nullptr, 0, nullptr, nullptr);
    if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32) {
      place.refuse("filters deflate and fletcher32", fmt::format("filter {}", filter));
    }
  }
  // one chunk is unpacked at a time, into memory of its size
  if (layout != H5D_CHUNKED) return;
  hsize_t dims[kMaxDimensions] = {};
  uint64_t chunk_bytes = element_bytes;
  const int rank = H5Pget_chunk(properties, kMaxDimensions, dims);
  for (int i = 0; i < std::min(rank, kMaxDimensions); ++i) {
    if (__builtin_mul_overflow(chunk_bytes, dims[i], &chunk_bytes) || chunk_bytes > kMaxChunkBytes) {
      place.refuse("chunks of at most 64 MiB", "larger ones");
    }
  }
}

// An array may claim any shape: believe only what its stored bytes can possibly hold.
void requirePlausibleSize(hid_t file, hid_t dataset, const Place& place, const std::vector<uint64_t>& shape,
                          uint64_t element_bytes) {
  uint64_t bytes = 0;
  if (!arrayBytes(shape, element_bytes, &bytes)) place.refuse("at most 2^38 bytes", "shape " + shapeText(shape));
  hsize_t file_bytes = 0;
  place.require(H5Fget_filesize(file, &file_bytes) >= 0, "a file with a size");
  const uint64_t stored_bytes = H5Dget_storage_size(dataset);
  if (stored_bytes > file_bytes || bytes > stored_bytes * kDeflateMaxRatio) {
    place.refuse("an array that its stored bytes can hold",
                 fmt::format("shape {} for {} stored bytes", shapeText(shape), stored_bytes));
  }
}

// The array of that name once its shape, type and storage are known to be what the caller expects.
Handle openArray(hid_t file, const Place& place, const std::string& name, const std::vector<uint64_t>& expected_shape,
                 const ElementType& element, uint64_t element_bytes) {
  Handle dataset = openDataset(file, place, name);
  const std::vector<uint64_t> shape = datasetShape(dataset, place);
  if (shape != expected_shape) place.refuse("shape " + shapeText(expected_shape), shapeText(shape));
  const Handle type(H5Dget_type(dataset), H5Tclose);
  place.require(type.ok(), "an element type");
  if (H5Tequal(type, element.file) <= 0) place.refuse("the element type of the format", "another type");
  requireOurLayout(dataset, place, element_bytes);
  requirePlausibleSize(file, dataset, place, shape, element_bytes);
  return dataset;
}

// Rows a chunk when the array is stored as encodeChunk stores it: deflate, then Fletcher-32, whole rows. 0: some other way.
uint64_t ownChunkRows(hid_t dataset, const std::vector<uint64_t>& shape) {
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (std::endian::native != std::endian::little || H5Pget_layout(properties) != H5D_CHUNKED) return 0;
  if (H5Pget_nfilters(properties) != 2) return 0;
  for (const auto& [i, wanted] : {std::pair{0u, H5Z_FILTER_DEFLATE}, {1u, H5Z_FILTER_FLETCHER32}}) {
    unsigned flags = 0;
    size_t value_count = 0;
    if (H5Pget_filter2(properties, i, &flags, &value_count, nullptr, 0, nullptr, nullptr) != wanted) return 0;
  }
  hsize_t dims[kMaxDimensions] = {};
  if (H5Pget_chunk(properties, kMaxDimensions, dims) != static_cast<int>(shape.size())) return 0;
  return std::equal(shape.begin() + 1, shape.end(), dims + 1) ? dims[0] : 0;
}

struct RowRange {
  uint64_t first, count;
};

// HDF5's own way, for arrays in any storage that requireOurLayout lets pass.
void fillRowsSlowly(hid_t dataset, const Place& place, const std::vector<uint64_t>& shape, RowRange rows, hid_t memory_type,
                    void* values) {
  std::vector<hsize_t> first(shape.size(), 0), count(shape.begin(), shape.end());
  first[0] = rows.first;
  count[0] = rows.count;
  const Handle file_space(H5Dget_space(dataset), H5Sclose);
  const Handle memory_space(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
  place.require(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr) >= 0, "rows");
  place.require(H5Dread(dataset, memory_type, memory_space, file_space, H5P_DEFAULT, values) >= 0, "undamaged data");
}

// Decodes the chunks that hold the rows.
template <class T>
void fillRows(hid_t dataset, const Place& place, const std::vector<uint64_t>& shape, RowRange rows, T* values) {
  const uint64_t chunk_rows = ownChunkRows(dataset, shape);
  if (chunk_rows == 0) return fillRowsSlowly(dataset, place, shape, rows, elementType(T{}).memory, values);
  uint64_t row_bytes = sizeof(T);
  for (size_t i = 1; i < shape.size(); ++i) row_bytes *= shape[i];
  const uint64_t chunk_bytes = chunk_rows * row_bytes, end = rows.first + rows.count;
  auto* const out = reinterpret_cast<uint8_t*>(values);
  std::vector<uint8_t> encoded, decoded;
  std::vector<hsize_t> offset(shape.size(), 0);
  for (uint64_t chunk = rows.first / chunk_rows * chunk_rows; chunk < end; chunk += chunk_rows) {
    offset[0] = chunk;
    hsize_t encoded_bytes = 0;
    place.require(H5Dget_chunk_storage_size(dataset, offset.data(), &encoded_bytes) >= 0, "undamaged data");
    // deflate stores what it cannot compress: a few bytes more than the data
    if (encoded_bytes > chunk_bytes + chunk_bytes / 8 + 1024)
      place.refuseDamage("undamaged data", "a chunk that is larger than its rows");
    encoded.resize(encoded_bytes);
    uint32_t skipped_filters = 0;
    place.require(H5Dread_chunk(dataset, H5P_DEFAULT, offset.data(), &skipped_filters, encoded.data()) >= 0, "undamaged data");
    const uint64_t from = std::max(chunk, rows.first), to = std::min(chunk + chunk_rows, end);
    const bool whole = to - from == chunk_rows;
    if (!whole) decoded.resize(chunk_bytes);
    uint8_t* const target = out + (from - rows.first) * row_bytes;
    if (skipped_filters != 0 || !decodeChunk(encoded.data(), encoded.size(), whole ? target : decoded.data(), chunk_bytes)) {
      place.refuseDamage("undamaged data", fmt::format("a wrong checksum in the chunk of row {}", chunk));
    }
    if (!whole) std::memcpy(target, decoded.data() + (from - chunk) * row_bytes, (to - from) * row_bytes);
  }
}

Handle openAttribute(hid_t file, const Place& place, const std::string& name) {
  const htri_t exists = H5Aexists(file, name.c_str());
  place.require(exists >= 0, "an attribute");
  if (exists == 0) place.refuse("an attribute", "none of that name");
  Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
  place.require(attribute.ok(), "an attribute");
  const Handle space(H5Aget_space(attribute), H5Sclose);
  place.require(space.ok(), "one value");
  if (H5Sget_simple_extent_type(space) != H5S_SCALAR) place.refuse("one value", "an array or nothing");
  return attribute;
}

template <class Number>
Number readNumber(hid_t file, const Place& place, const std::string& name, const char* expected) {
  silenceHdf5();
  const Handle attribute = openAttribute(file, place, name);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  place.require(type.ok(), expected);
  const ElementType element = elementType(Number{});
  if (H5Tequal(type, element.file) <= 0) place.refuse(expected, "another type");
  Number value = 0;
  place.require(H5Aread(attribute, element.memory, &value) >= 0, "an undamaged value");
  return value;
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string& path) : path_(path) {
  silenceHdf5();
  requireOurSuperblock(path);
  requireMemoryOfAFile();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);
  file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (file_ < 0) Place{path_, "open"}.refuseDamage("a whole HDF5 file", innermostError());
}

Hdf5Reader::~Hdf5Reader() {
  if (file_ >= 0) H5Fclose(file_);
}

std::vector<uint64_t> Hdf5Reader::shape(const std::string& name) const {
  silenceHdf5();
  const Place place{path_, "dataset " + name};
  const Handle dataset = openDataset(file_, place, name);
  return datasetShape(dataset, place);
}

template <class T>
std::vector<T> Hdf5Reader::read(const std::string& name, const std::vector<uint64_t>& expected_shape) const {
  silenceHdf5();
  const Place place{path_, "dataset " + name};
  const Handle dataset = openArray(file_, place, name, expected_shape, elementType(T{}), sizeof(T));
  uint64_t bytes = 0;
  NLG_CHECK(arrayBytes(expected_shape, sizeof(T), &bytes), ==, true);
  std::vector<T> values(bytes / sizeof(T));
  if (!values.empty()) fillRows(dataset, place, expected_shape, {0, expected_shape[0]}, values.data());
  return values;
}

template <class T>
void Hdf5Reader::readRows(const std::string& name, const std::vector<uint64_t>& expected_shape, uint64_t first, uint64_t count,
                          T* values) const {
  silenceHdf5();
  NLG_CHECK(first + count, <=, expected_shape[0]);
  const Place place{path_, "dataset " + name};
  const Handle dataset = openArray(file_, place, name, expected_shape, elementType(T{}), sizeof(T));
  uint64_t bytes = 0;
  NLG_CHECK(arrayBytes(expected_shape, sizeof(T), &bytes), ==, true);
  if (bytes > 0 && count > 0) fillRows(dataset, place, expected_shape, {first, count}, values);
}

void Hdf5Reader::verifyDigest() const {
  silenceHdf5();
  const Place place{path_, std::string("dataset ") + kDigestName};
  const std::vector<uint8_t> stored = read<uint8_t>(kDigestName, {kDigestBytes});
  const Handle dataset = openDataset(file_, place, kDigestName);
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) place.refuse("contiguous bytes", "chunks");
  if (fileSha256Bytes(path_, {offset, kDigestBytes}) != stored) place.refuseDamage("the SHA-256 of the file", "another digest");
}

std::string Hdf5Reader::readTextAttribute(const std::string& name) const {
  silenceHdf5();
  const Place place{path_, "attribute " + name};
  const Handle attribute = openAttribute(file_, place, name);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  place.require(type.ok(), "a text");
  const bool fixed_text = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  if (!fixed_text) place.refuse("a text of fixed length", "another type");
  const uint64_t size = H5Tget_size(type);
  if (size > kMaxTextBytes) place.refuse("at most 16 MiB of text", fmt::format("{} bytes", size));
  std::string text(size, '\0');
  place.require(H5Aread(attribute, type, text.data()) >= 0, "an undamaged text");
  while (!text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

bool Hdf5Reader::hasAttribute(const std::string& name) const { return H5Aexists(file_, name.c_str()) > 0; }

uint64_t Hdf5Reader::readIntegerAttribute(const std::string& name) const {
  return readNumber<uint64_t>(file_, {path_, "attribute " + name}, name, "an unsigned 64-bit integer");
}

double Hdf5Reader::readRealAttribute(const std::string& name) const {
  const Place place{path_, "attribute " + name};
  const double value = readNumber<double>(file_, place, name, "a 64-bit real number");
  if (!std::isfinite(value)) place.refuse("a finite number", fmt::format("{}", value));
  return value;
}

#define NLG_HDF5_ELEMENT(T)                                                                            \
  template std::vector<T> Hdf5Reader::read<T>(const std::string&, const std::vector<uint64_t>&) const; \
  template void Hdf5Reader::readRows<T>(const std::string&, const std::vector<uint64_t>&, uint64_t, uint64_t, T*) const;
NLG_HDF5_ELEMENT(uint8_t)
NLG_HDF5_ELEMENT(uint32_t)
NLG_HDF5_ELEMENT(int32_t)
NLG_HDF5_ELEMENT(uint64_t)
NLG_HDF5_ELEMENT(float)
NLG_HDF5_ELEMENT(double)
#undef NLG_HDF5_ELEMENT

}  // namespace nlg
