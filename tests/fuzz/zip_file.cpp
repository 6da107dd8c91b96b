#include "tests/fuzz/zip_file.h"

#include <libdeflate.h>

namespace nlg::fuzz {
namespace {

constexpr size_t kLocalBytes = 30, kCentralBytes = 46;

std::string word(uint64_t value, int byte_count) {
  std::string bytes;
  for (int i = 0; i < byte_count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
  return bytes;
}

uint64_t wordAt(const std::string& bytes, size_t at, int byte_count) {
  uint64_t value = 0;
  for (int i = byte_count; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + static_cast<size_t>(i)]);
  return value;
}

uint32_t checksumOf(const std::string& bytes, size_t first, size_t count) {
  return libdeflate_crc32(0, bytes.data() + first, count);
}

}  // namespace

std::string zipOf(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string archive, directory;
  for (const auto& [name, bytes] : files) {
    // version, flags, method, time and date, checksum, sizes, name, extra
    const std::string common = word(20, 2) + word(0, 2) + word(0, 2) + word(0x21 << 16, 4) +
                               word(checksumOf(bytes, 0, bytes.size()), 4) + word(bytes.size(), 4) + word(bytes.size(), 4) +
                               word(name.size(), 2) + word(0, 2);
    directory +=
        "PK\x01\x02" + word(20, 2) + common + word(0, 2) + word(0, 2) + word(0, 2) + word(0, 4) + word(archive.size(), 4) + name;
    archive += "PK\x03\x04" + common + name + bytes;
  }
  return archive + directory + "PK\x05\x06" + word(0, 4) + word(files.size(), 2) + word(files.size(), 2) +
         word(directory.size(), 4) + word(archive.size(), 4) + word(0, 2);
}

void putZipChecksumsRight(std::string* archive) {
  for (size_t at = 0; (at = archive->find("PK\x01\x02", at)) != archive->npos; at += 4) {
    if (archive->size() - at < kCentralBytes || wordAt(*archive, at + 10, 2) != 0) continue;
    const uint64_t byte_count = wordAt(*archive, at + 20, 4), local = wordAt(*archive, at + 42, 4);
    if (archive->size() < kLocalBytes || local > archive->size() - kLocalBytes) continue;
    const uint64_t first = local + kLocalBytes + wordAt(*archive, local + 26, 2) + wordAt(*archive, local + 28, 2);
    if (first > archive->size() || byte_count > archive->size() - first) continue;
    const std::string checksum = word(checksumOf(*archive, first, byte_count), 4);
    archive->replace(at + 16, 4, checksum);
    archive->replace(local + 14, 4, checksum);
  }
}

}  // namespace nlg::fuzz
