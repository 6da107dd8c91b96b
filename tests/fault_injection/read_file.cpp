// Reads one file as an engine would: fault_injection_read READER FILE. The readers that no tool has: of the C++ library, of
// the C library, and the header that is a whole reader in C. Exit code 0: it was accepted; 3: refused, with one line on stderr.
//
//   weights, weights-c       a generator
//   grid, grid-c             a light grid
//   grid-header              grid.bin, by nlg_light_grid.h
#include <unistd.h>

#include <array>
#include <cstring>
#include <iostream>
#include <string>

#include "nlg/generator.h"
#include "nlg/light_grid.h"
#include "nlg/nlg.h"
#include "runtime_eval/regular_file/regular_file.h"

extern "C" int cHeaderIsWhole(const uint8_t* bytes, size_t size);

namespace {

constexpr int kAccepted = 0, kUsage = 2, kRefused = 3;

int refused(const std::string& detail) {
  std::cerr << "fault_injection_read: error: " << detail << '\n';
  return kRefused;
}

int verdict(const nlg::FileResult& result) { return result.ok() ? kAccepted : refused(result.detail); }

int verdict(nlg_status status, const char* detail) { return status == NLG_OK ? kAccepted : refused(detail); }

int readWeights(const char* path) {
  nlg::Generator generator;
  return verdict(nlg::Generator::load(path, &generator));
}

int readWeightsInC(const char* path) {
  nlg_generator* generator = nullptr;
  std::array<char, 512> detail{};
  const nlg_status status = nlg_generator_load(path, &generator, detail.data(), detail.size());
  nlg_generator_free(generator);
  return verdict(status, detail.data());
}

int readGrid(const char* path) {
  nlg::LightGrid grid;
  nlg::GridMetadata metadata;
  return verdict(nlg::readLightGridFile(path, &grid, &metadata));
}

int readGridInC(const char* path) {
  nlg_light_grid* grid = nullptr;
  std::array<char, 512> detail{};
  const nlg_status status = nlg_light_grid_load(path, &grid, detail.data(), detail.size());
  nlg_light_grid_free(grid);
  return verdict(status, detail.data());
}

int readGridByHeader(const char* path) {
  std::string bytes, fault;
  const int file = nlg::openRegularFile(path, &fault);
  if (file < 0) return refused(fault);
  std::array<char, 65536> block;
  for (ssize_t count = 0; (count = ::read(file, block.data(), block.size())) > 0;)
    bytes.append(block.data(), static_cast<size_t>(count));
  ::close(file);
  return cHeaderIsWhole(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()) == 1 ? kAccepted
                                                                                           : refused("another digest");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string reader = argc >= 3 ? argv[1] : "";
  if (argc == 3 && reader == "weights") return readWeights(argv[2]);
  if (argc == 3 && reader == "weights-c") return readWeightsInC(argv[2]);
  if (argc == 3 && reader == "grid") return readGrid(argv[2]);
  if (argc == 3 && reader == "grid-c") return readGridInC(argv[2]);
  if (argc == 3 && reader == "grid-header") return readGridByHeader(argv[2]);
  std::cerr << "usage: fault_injection_read weights|weights-c|grid|grid-c|grid-header FILE\n";
  return kUsage;
}
