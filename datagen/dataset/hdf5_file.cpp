#include "datagen/dataset/hdf5_file.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kChunkBytes = uint64_t{256} << 10;
constexpr uint64_t kMaxChunkBytes = uint64_t{64} << 20;
constexpr uint64_t kMaxArrayBytes = uint64_t{1} << 38;
constexpr uint64_t kMaxTextBytes = uint64_t{16} << 20;
constexpr uint64_t kDeflateMaxRatio = 1040;  // deflate cannot expand by more than 1032; some room for its own header
constexpr int kMaxDimensions = 4;

// An HDF5 identifier that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  bool ok() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// Every public function starts here: HDF5 keeps its error stack, and whether to print it, per thread.
void silenceHdf5() {
  // after a full disk, HDF5's own handler at exit writes once more to what is gone, and crashes; we close everything ourselves
  static const herr_t no_exit_handler = H5dont_atexit();
  static_cast<void>(no_exit_handler);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

// What HDF5 says at the place where the error arose; when the system refused, only the system's words (the rest holds a time).
std::string innermostError() {
  std::string text = "an unknown HDF5 error";
  const auto takeFirst = [](unsigned depth, const H5E_error2_t* error, void* data) -> herr_t {
    if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(data) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, takeFirst, &text);
  const std::string mark = "error message = '";
  const size_t begin = text.find(mark);
  if (begin == std::string::npos) return text;
  text = text.substr(begin + mark.size());
  text = text.substr(0, text.find('\''));
  return text.find("No space left") == std::string::npos ? text : text + " (the disk is full)";
}

// An element's type as it lies in the file, on any machine, and as this machine holds it.
struct ElementType {
  hid_t file, memory;
};
ElementType elementType(uint8_t) { return {H5T_STD_U8LE, H5T_NATIVE_UINT8}; }
ElementType elementType(uint32_t) { return {H5T_STD_U32LE, H5T_NATIVE_UINT32}; }
ElementType elementType(int32_t) { return {H5T_STD_I32LE, H5T_NATIVE_INT32}; }
ElementType elementType(uint64_t) { return {H5T_STD_U64LE, H5T_NATIVE_UINT64}; }
ElementType elementType(float) { return {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT}; }
ElementType elementType(double) { return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE}; }

// Bytes of an array; false when they exceed what we ever handle.
bool arrayBytes(const std::vector<uint64_t>& shape, uint64_t element_bytes, uint64_t* bytes) {
  *bytes = element_bytes;
  // an empty array is empty whatever its other dimensions say
  if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) *bytes = 0;
  for (const uint64_t count : shape) {
    if (__builtin_mul_overflow(*bytes, count, bytes) || *bytes > kMaxArrayBytes) return false;
  }
  return true;
}

// Whole rows as far as kChunkBytes go; one row that is larger is cut along its own dimensions.
std::vector<hsize_t> chunkShape(const std::vector<uint64_t>& shape, uint64_t element_bytes) {
  std::vector<hsize_t> chunk(shape.begin(), shape.end());
  uint64_t row_bytes = element_bytes;
  for (size_t i = 1; i < shape.size(); ++i) row_bytes *= shape[i];
  for (size_t i = 0; i < shape.size(); ++i) {
    chunk[i] = std::clamp<uint64_t>(kChunkBytes / row_bytes, 1, shape[i]);
    if (i + 1 < shape.size()) row_bytes /= shape[i + 1];
  }
  return chunk;
}

std::string shapeText(const std::vector<uint64_t>& shape) { return fmt::format("{}", fmt::join(shape, " x ")); }

// Throws OutputError when HDF5 says that something went wrong.
void requireWritten(bool good, const std::string& path, const std::string& what) {
  if (!good) throw OutputError(path, what + ": " + innermostError());
}

// What one reading call needs to point at the culprit.
struct Place {
  const std::string& path;
  std::string what;
  [[noreturn]] void refuse(const std::string& expected, const std::string& got) const {
    throw InputError(path, what, expected, got);
  }
  void require(bool good, const std::string& expected) const {
    if (!good) refuse(expected, innermostError());
  }
};

// Older superblocks carry no checksum, and HDF5's readers of them trust what they read: files of ours never have one.
void requireOurSuperblock(const std::string& path) {
  const Place place{path, "byte 0"};
  std::ifstream file(path, std::ios::binary);
  if (!file) place.refuse("a readable HDF5 file", std::strerror(errno));
  char start[9] = {};
  file.read(start, sizeof start);
  if (file.gcount() != sizeof start || std::memcmp(start, "\x89HDF\r\n\x1a\n", 8) != 0) {
    place.refuse("an HDF5 file", "another or a truncated one");
  }
  if (start[8] != 3) place.refuse("an HDF5 superblock of version 3", std::to_string(start[8]));
}

Handle openDataset(hid_t file, const Place& place, const std::string& name) {
  H5L_info_t link{};
  place.require(H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT) >= 0, "an array");
  // any other link may lead into a file that nobody named
  if (link.type != H5L_TYPE_HARD) place.refuse("an array", "a link to elsewhere");
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
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  place.require(properties.ok(), "a storage layout");
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (H5Pget_external_count(properties) != 0 || layout == H5D_VIRTUAL) place.refuse("data in this file", "data in another");
  const int filter_count = H5Pget_nfilters(properties);
  for (int i = 0; i < filter_count; ++i) {
    unsigned flags = 0;
    size_t value_count = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties, i, &flags, &value_count, nullptr, 0, nullptr, nullptr);
    if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32) {
      place.refuse("filters deflate and fletcher32", fmt::format("filter {}", filter));
    }
  }
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
                 fmt::format("shape {} in {} stored bytes", shapeText(shape), stored_bytes));
  }
}

Handle openAttribute(hid_t file, const Place& place, const std::string& name) {
  Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
  place.require(attribute.ok(), "an attribute");
  const Handle space(H5Aget_space(attribute), H5Sclose);
  place.require(space.ok(), "one value");
  if (H5Sget_simple_extent_type(space) != H5S_SCALAR) place.refuse("one value", "an array or nothing");
  return attribute;
}

void writeScalarAttribute(hid_t file, const std::string& path, const std::string& name, hid_t file_type, hid_t memory_type,
                          const void* value) {
  silenceHdf5();
  const std::string what = "attribute " + name;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  requireWritten(attribute.ok(), path, what);
  requireWritten(H5Awrite(attribute, memory_type, value) >= 0, path, what);
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::string& path) : path_(path) {
  silenceHdf5();
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  // from this version on every block of HDF5's own bookkeeping carries a checksum
  H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
  // readers never see a file under construction, and cluster file systems often know no locks
  H5Pset_file_locking(access, false, true);
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
  requireWritten(file_ >= 0, path_, "create");
}

Hdf5Writer::~Hdf5Writer() {
  if (file_ >= 0) H5Fclose(file_);
}

template <class T>
void Hdf5Writer::write(const std::string& name, const std::vector<uint64_t>& shape, const T* data) {
  silenceHdf5();
  NLG_CHECK(file_, >=, 0);
  NLG_CHECK(shape.size(), >=, 1u);
  NLG_CHECK(shape.size(), <=, static_cast<size_t>(kMaxDimensions));
  uint64_t bytes = 0;
  NLG_CHECK(arrayBytes(shape, sizeof(T), &bytes), ==, true);
  const std::string what = "dataset " + name;
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  if (bytes > 0) {
    H5Pset_chunk(properties, static_cast<int>(shape.size()), chunkShape(shape, sizeof(T)).data());
    H5Pset_deflate(properties, 1);
    H5Pset_fletcher32(properties);
  }
  const std::vector<hsize_t> dims(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose);
  const Handle dataset(H5Dcreate2(file_, name.c_str(), elementType(T{}).file, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                       H5Dclose);
  requireWritten(dataset.ok(), path_, what);
  if (bytes == 0) return;
  requireWritten(H5Dwrite(dataset, elementType(T{}).memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, path_, what);
  requireWritten(H5Dflush(dataset) >= 0, path_, what);
}

void Hdf5Writer::writeAttribute(const std::string& name, const std::string& value) {
  silenceHdf5();
  NLG_CHECK(file_, >=, 0);
  NLG_CHECK(value.size(), <=, kMaxTextBytes);
  // fixed length, padded with NULs: HDF5 has no texts of length 0
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<size_t>(value.size(), 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  writeScalarAttribute(file_, path_, name, type, type, value.c_str());
}

void Hdf5Writer::writeAttribute(const std::string& name, uint64_t value) {
  NLG_CHECK(file_, >=, 0);
  writeScalarAttribute(file_, path_, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

void Hdf5Writer::close() {
  silenceHdf5();
  if (file_ < 0) return;
  const bool closed = H5Fclose(std::exchange(file_, -1)) >= 0;
  requireWritten(closed, path_, "close");
}

Hdf5Reader::Hdf5Reader(const std::string& path) : path_(path) {
  silenceHdf5();
  requireOurSuperblock(path);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);
  file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (file_ < 0) Place{path_, "open"}.refuse("a whole HDF5 file", innermostError());
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
  const Handle dataset = openDataset(file_, place, name);
  const std::vector<uint64_t> shape = datasetShape(dataset, place);
  if (shape != expected_shape) place.refuse("shape " + shapeText(expected_shape), shapeText(shape));
  const Handle type(H5Dget_type(dataset), H5Tclose);
  place.require(type.ok(), "an element type");
  if (H5Tequal(type, elementType(T{}).file) <= 0) place.refuse("the element type of the contract", "another");
  requireOurLayout(dataset, place, sizeof(T));
  requirePlausibleSize(file_, dataset, place, shape, sizeof(T));
  uint64_t bytes = 0;
  NLG_CHECK(arrayBytes(shape, sizeof(T), &bytes), ==, true);
  std::vector<T> values(bytes / sizeof(T));
  if (values.empty()) return values;
  place.require(H5Dread(dataset, elementType(T{}).memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0, "undamaged data");
  return values;
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

uint64_t Hdf5Reader::readIntegerAttribute(const std::string& name) const {
  silenceHdf5();
  const Place place{path_, "attribute " + name};
  const Handle attribute = openAttribute(file_, place, name);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  place.require(type.ok(), "an unsigned 64-bit integer");
  if (H5Tequal(type, H5T_STD_U64LE) <= 0) place.refuse("an unsigned 64-bit integer", "another type");
  uint64_t value = 0;
  place.require(H5Aread(attribute, H5T_NATIVE_UINT64, &value) >= 0, "an undamaged value");
  return value;
}

#define NLG_HDF5_ELEMENT(T)                                                                       \
  template void Hdf5Writer::write<T>(const std::string&, const std::vector<uint64_t>&, const T*); \
  template std::vector<T> Hdf5Reader::read<T>(const std::string&, const std::vector<uint64_t>&) const;
NLG_HDF5_ELEMENT(uint8_t)
NLG_HDF5_ELEMENT(uint32_t)
NLG_HDF5_ELEMENT(int32_t)
NLG_HDF5_ELEMENT(uint64_t)
NLG_HDF5_ELEMENT(float)
NLG_HDF5_ELEMENT(double)
#undef NLG_HDF5_ELEMENT

}  // namespace nlg
