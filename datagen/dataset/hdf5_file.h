// Reads and writes HDF5 files: named arrays and attributes, with errors that name file and place. Only this code uses HDF5.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nlg {

class Hdf5Writer {
 public:
  // Creates path (truncating it): write to the temporary name of writeAtomically.
  // throws OutputError, as every function here does when HDF5 cannot write (disk full)
  explicit Hdf5Writer(const std::string& path);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  // Row-major array of the given shape, 1 to 4 dimensions; chunked by rows (about 256 kB a chunk), gzip 1 and Fletcher-32 when
  // it is not empty. The same calls give the same bytes, whenever they are made.
  template <class T>
  void write(const std::string& name, const std::vector<uint64_t>& shape, const T* data);
  void writeAttribute(const std::string& name, const std::string& value);
  void writeAttribute(const std::string& name, uint64_t value);
  void writeAttribute(const std::string& name, double value);

  // An array of no rows yet that grows by chunks of chunk_rows rows, stored as encodeChunk (chunk_codec.h) makes them.
  // columns   none: one value a row; otherwise the row's shape, without zeros
  template <class T>
  void makeGrowing(const std::string& name, const std::vector<uint64_t>& columns, uint64_t chunk_rows);
  // Appends to the array that makeGrowing made. encoded holds chunk_rows rows, of which the first row_count count; only the
  // last chunk of an array may have fewer than chunk_rows.
  void appendChunk(const std::string& name, const std::vector<uint8_t>& encoded, uint64_t row_count);

  // Adds the array `file_sha256` (32 bytes): the SHA-256 of the whole file with these 32 bytes taken as zeros; then closes.
  void closeWithDigest();

  // Flushes and closes; call it to learn of a full disk (the destructor closes silently).
  void close();

 private:
  struct Growing {
    int64_t dataset;
    uint64_t chunk_rows, row_count;
    std::vector<uint64_t> columns;
  };
  // returns whether all of them could be closed
  bool closeGrowing();

  std::string path_;
  int64_t file_ = -1;
  std::map<std::string, Growing> growing_;
};

class Hdf5Reader {
 public:
  // throws InputError when the file is missing, truncated, no HDF5 file, or has an older superblock than version 3 (ours have
  // it; h5py writes it with libver="latest"): older ones carry no checksums. Here and below it is a DamageError where HDF5's own
  // structure or a checksum does not hold; a file that is sound but another than expected is no damage
  explicit Hdf5Reader(const std::string& path);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  // The shape of an array, 1 to 4 dimensions. throws InputError when there is none of that name in this very file (no links)
  std::vector<uint64_t> shape(const std::string& name) const;
  // A whole array, whose shape and element type must be exactly these. throws InputError (shape, type, checksum); refuses an
  // array that claims more than its stored bytes can hold (deflate: 1 to 1032), before any memory is taken
  template <class T>
  std::vector<T> read(const std::string& name, const std::vector<uint64_t>& expected_shape) const;
  // Rows [first, first + count) of such an array, into values (count rows); decodes only the chunks that hold them.
  template <class T>
  void readRows(const std::string& name, const std::vector<uint64_t>& expected_shape, uint64_t first, uint64_t count,
                T* values) const;
  // Compares every byte of the file with the digest that closeWithDigest stored. throws InputError
  void verifyDigest() const;
  bool hasAttribute(const std::string& name) const;
  std::string readTextAttribute(const std::string& name) const;
  uint64_t readIntegerAttribute(const std::string& name) const;
  double readRealAttribute(const std::string& name) const;  // finite

 private:
  std::string path_;
  int64_t file_ = -1;
};

// write, makeGrowing, read and readRows exist for T = uint8_t, uint32_t, int32_t, uint64_t, float, double.

}  // namespace nlg
