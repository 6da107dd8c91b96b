#include <bit>
#include <fstream>

#include "datagen/dataset/hdf5_detail.h"
#include "datagen/dataset/hdf5_file.h"
#include "datagen/functions/chunk_codec.h"
#include "tool/atomic_file.h"

namespace nlg {

using namespace hdf5;

namespace {

constexpr uint64_t kChunkBytes = uint64_t{256} << 10;

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

// Throws OutputError when HDF5 says that something went wrong.
void requireWritten(bool good, const std::string& path, const std::string& what) {
  if (!good) throw OutputError(path, what + ": " + innermostError());
}

void writeScalarAttribute(hid_t file, const std::string& path, const std::string& name, const ElementType& type,
                          const void* value) {
  silenceHdf5();
  NLG_CHECK(file, >=, 0);
  const std::string what = "attribute " + name;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, name.c_str(), type.file, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  requireWritten(attribute.ok(), path, what);
  requireWritten(H5Awrite(attribute, type.memory, value) >= 0, path, what);
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
  requireMemoryOfAFile();
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
  requireWritten(file_ >= 0, path_, "create");
}

Hdf5Writer::~Hdf5Writer() {
  closeGrowing();
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
  // no times: the same data gives the same bytes
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  // only chunked data takes filters; higher levels of deflate save little (docs/lab/measurements.md)
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
  // an array of no elements has a shape, and nothing to write
  if (bytes == 0) return;
  requireWritten(H5Dwrite(dataset, elementType(T{}).memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, path_, what);
  requireWritten(H5Dflush(dataset) >= 0, path_, what);
}

void Hdf5Writer::writeAttribute(const std::string& name, const std::string& value) {
  silenceHdf5();
  NLG_CHECK(value.size(), <=, kMaxTextBytes);
  // fixed length, padded with NULs: HDF5 has no texts of length 0
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<size_t>(value.size(), 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  writeScalarAttribute(file_, path_, name, {type, type}, value.c_str());
}

void Hdf5Writer::writeAttribute(const std::string& name, uint64_t value) {
  writeScalarAttribute(file_, path_, name, elementType(value), &value);
}

void Hdf5Writer::writeAttribute(const std::string& name, double value) {
  writeScalarAttribute(file_, path_, name, elementType(value), &value);
}

template <class T>
void Hdf5Writer::makeGrowing(const std::string& name, const std::vector<uint64_t>& columns, uint64_t chunk_rows) {
  static_assert(std::endian::native == std::endian::little, "chunks are stored as they lie in memory");
  silenceHdf5();
  NLG_CHECK(file_, >=, 0);
  NLG_CHECK(columns.size(), <, static_cast<size_t>(kMaxDimensions));
  std::vector<hsize_t> dims(columns.begin(), columns.end()), limits = dims, chunk = dims;
  dims.insert(dims.begin(), 0);
  limits.insert(limits.begin(), H5S_UNLIMITED);
  chunk.insert(chunk.begin(), chunk_rows);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  H5Pset_deflate(properties, kDeflateLevel);
  H5Pset_fletcher32(properties);
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), limits.data()), H5Sclose);
  const hid_t dataset = H5Dcreate2(file_, name.c_str(), elementType(T{}).file, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  requireWritten(dataset >= 0, path_, "dataset " + name);
  growing_[name] = {dataset, chunk_rows, 0, columns};
}

void Hdf5Writer::appendChunk(const std::string& name, const std::vector<uint8_t>& encoded, uint64_t row_count) {
  silenceHdf5();
  Growing& array = growing_.at(name);
  NLG_CHECK(array.row_count % array.chunk_rows, ==, 0u);
  NLG_CHECK(row_count, <=, array.chunk_rows);
  std::vector<hsize_t> dims(array.columns.begin(), array.columns.end()), offset(dims.size() + 1, 0);
  offset[0] = array.row_count;
  array.row_count += row_count;
  dims.insert(dims.begin(), array.row_count);
  const std::string what = "dataset " + name;
  requireWritten(H5Dset_extent(array.dataset, dims.data()) >= 0, path_, what);
  requireWritten(H5Dwrite_chunk(array.dataset, H5P_DEFAULT, 0, offset.data(), encoded.size(), encoded.data()) >= 0, path_, what);
}

bool Hdf5Writer::closeGrowing() {
  bool closed = true;
  for (const auto& [name, array] : growing_) closed = H5Dclose(array.dataset) >= 0 && closed;
  growing_.clear();
  return closed;
}

void Hdf5Writer::closeWithDigest() {
  const std::string what = std::string("dataset ") + kDigestName;
  haddr_t offset = HADDR_UNDEF;
  {
    silenceHdf5();
    // the digest's place first, with zeros: allocated early, so that its offset is known
    const std::vector<uint8_t> zeros(kDigestBytes, 0);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(properties, false);
    H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY);
    const hsize_t size = kDigestBytes;
    const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Handle dataset(H5Dcreate2(file_, kDigestName, H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
    requireWritten(dataset.ok(), path_, what);
    requireWritten(H5Dwrite(dataset, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data()) >= 0, path_, what);
    offset = H5Dget_offset(dataset);
    requireWritten(offset != HADDR_UNDEF, path_, what);
  }
  // then the digest of the closed file, with zeros in this place, is written there past HDF5
  close();
  const std::vector<uint8_t> digest = fileSha256Bytes(path_, {offset, kDigestBytes});
  std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(offset));
  file.write(reinterpret_cast<const char*>(digest.data()), static_cast<std::streamsize>(digest.size()));
  file.close();
  if (!file) throw OutputError(path_, what);
}

void Hdf5Writer::close() {
  silenceHdf5();
  if (file_ < 0) return;
  const bool arrays_closed = closeGrowing();
  const bool closed = H5Fclose(std::exchange(file_, -1)) >= 0 && arrays_closed;
  requireWritten(closed, path_, "close");
}

#define NLG_HDF5_ELEMENT(T)                                                                       \
  template void Hdf5Writer::write<T>(const std::string&, const std::vector<uint64_t>&, const T*); \
  template void Hdf5Writer::makeGrowing<T>(const std::string&, const std::vector<uint64_t>&, uint64_t);
NLG_HDF5_ELEMENT(uint8_t)
NLG_HDF5_ELEMENT(uint32_t)
NLG_HDF5_ELEMENT(int32_t)
NLG_HDF5_ELEMENT(uint64_t)
NLG_HDF5_ELEMENT(float)
NLG_HDF5_ELEMENT(double)
#undef NLG_HDF5_ELEMENT

}  // namespace nlg
