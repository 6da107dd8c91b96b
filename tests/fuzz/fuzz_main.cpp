#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/fuzz.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* bytes, size_t size, size_t max_size);

namespace nlg::fuzz {
namespace {

bool writeSeeds(const std::string& folder) {
  bool written = true;
  for (const auto& [name, bytes] : seeds()) {
    std::ofstream stream(folder + "/" + name, std::ios::binary);
    stream << bytes;
    written = written && stream.flush();
  }
  return written;
}

// Begin and length of every number of a text, or of every text in quotes, the quotes included.
using Parts = std::vector<std::pair<size_t, size_t>>;
Parts numbersOf(std::string_view text) {
  Parts found;
  for (size_t i = 0; (i = text.find_first_of("0123456789", i)) != text.npos; i += found.back().second) {
    found.emplace_back(i, std::min(text.find_first_not_of("0123456789", i), text.size()) - i);
  }
  return found;
}
Parts quotedOf(std::string_view text) {
  Parts found;
  for (size_t i = 0; (i = text.find('"', i)) != text.npos; i += found.back().second) {
    found.emplace_back(i, std::min(text.find('"', i + 1), text.size() - 1) + 1 - i);
  }
  return found;
}

// Something near a number, or at a limit.
std::string neighbour(std::string_view digits, Random& random) {
  uint64_t value = 0;
  for (const char digit : digits) value = 10 * value + static_cast<uint64_t>(digit - '0');
  const uint64_t choices[] = {value + 1, value - 1, value + 4 * random.below(32),   value - 4 * random.below(32),
                              value / 2, 0,         uint64_t{1} << random.below(64)};
  return std::to_string(choices[random.below(std::size(choices))]);
}

}  // namespace

std::string mutatedBlindly(std::string bytes, size_t max_size) {
  const size_t size = bytes.size();
  bytes.resize(std::max(max_size, size));
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), size, max_size));
  return bytes;
}

std::string mutatedText(const std::string& text, Random& random) {
  const bool number = random.chance(0.7);
  const Parts parts = number ? numbersOf(text) : quotedOf(text);
  if (parts.empty()) return text;
  const auto part = [&] { return parts[random.below(static_cast<uint32_t>(parts.size()))]; };
  const auto [begin, length] = part();
  const auto [other_begin, other_length] = part();
  const bool own = !number || random.chance(0.3);
  const std::string_view view = text;
  std::string result = text;
  return result.replace(begin, length,
                        own ? text.substr(other_begin, other_length) : neighbour(view.substr(begin, length), random));
}

std::string mutatedTextOrBlindly(std::string bytes, size_t max_size, Random& random) {
  if (random.chance(0.5)) return mutatedBlindly(std::move(bytes), max_size);
  std::string result = mutatedText(bytes, random);
  return result.size() <= max_size ? result : mutatedBlindly(std::move(bytes), max_size);
}

namespace fs = std::filesystem;

ScratchFile::ScratchFile(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("nlg_fuzz_" + std::to_string(::getpid()));
  fs::create_directory(folder);
  path_ = folder / name;
  write("");
}

ScratchFile::~ScratchFile() {
  std::error_code ignored;
  fs::remove(path_, ignored);
  // gone with the last file
  fs::remove(fs::path(path_).parent_path(), ignored);
}

void ScratchFile::write(std::string_view bytes) const {
  const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const ssize_t written = ::write(file, bytes.data(), bytes.size());
  FUZZ_CHECK(written == static_cast<ssize_t>(bytes.size()) && ::close(file) == 0, std::strerror(errno));
}

void ScratchFile::overwrite(uint64_t first, std::string_view bytes) const {
  const int file = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  const ssize_t written = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(first));
  FUZZ_CHECK(written == static_cast<ssize_t>(bytes.size()) && ::close(file) == 0, std::strerror(errno));
}

std::string ScratchFile::read() const {
  std::ifstream stream(path_, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace nlg::fuzz

// What would take more is refused as by a machine that has no more: a reader may not ask for it, or must end in one line.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "max_allocation_size_mb=1024:allocator_may_return_null=1"; }

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc == 3 && std::strcmp((*argv)[1], "--seeds") == 0) std::exit(nlg::fuzz::writeSeeds((*argv)[2]) ? 0 : 2);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  nlg::fuzz::readOne({reinterpret_cast<const char*>(bytes), size});
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* bytes, size_t size, size_t max_size, unsigned int seed) {
  nlg::Random random(seed);
  std::string result = nlg::fuzz::mutated(std::string(reinterpret_cast<const char*>(bytes), size), max_size, random);
  // what was put right behind a mutation may have grown
  result.resize(std::min(result.size(), max_size));
  std::memcpy(bytes, result.data(), result.size());
  return result.size();
}
