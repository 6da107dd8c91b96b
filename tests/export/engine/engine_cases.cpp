// Light grids for engine_files_test.py: engine_cases FOLDER writes grid.safetensors, and dark.safetensors, which no format takes.

#include <cstdlib>
#include <iostream>

#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tool/atomic_file.h"

namespace {

void write(const nlg::LightGrid& grid, const std::string& path) {
  std::string bytes;
  const nlg::FileResult result = nlg::serializeLightGrid(grid, {}, {{"scene", "case"}}, &bytes);
  if (!result.ok()) {
    std::cerr << path << ": " << result.detail << '\n';
    std::exit(1);
  }
  nlg::writeFileAtomically(path, bytes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = std::string(argv[1]) + "/";
  nlg::LightGrid grid = nlg::litGrid(nlg::smallTree(), 1);
  write(grid, folder + "grid.safetensors");
  grid.light.clear();
  write(grid, folder + "dark.safetensors");
  return 0;
}
