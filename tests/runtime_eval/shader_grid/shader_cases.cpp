// What the tests of shaders in a browser compare: for each precision of theta a folder with what nlg-export shader writes and,
// as raw floats and integers,
//
//     places.bin    8 floats a place: position, 0, normal, 0
//     lights.bin    4 floats a place: irradiance by lookUpIrradiance, status
//     box.bin       the uniform block of resample.comp
//     texels.bin    28 floats a texel, by resampleLight: 27 of radiance times the texel's say, then that say
//
//     shader_cases FOLDER PLACE_COUNT

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include "export/shader/shader_export.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tests/runtime_eval/shader_grid/resampled_box.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

template <class Number>
void write(const std::filesystem::path& path, const std::vector<Number>& numbers) {
  writeFileAtomically(path.string(), {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)});
}

void writeCase(const std::filesystem::path& folder, ThetaPrecision precision, size_t place_count) {
  const LightGrid grid = everyRepresentation(precision, 7);
  ShaderGrid packed;
  const FileResult result = packShaderGrid(grid, &packed);
  if (!result.ok()) throw std::runtime_error(result.detail);
  writeShader(packed, folder.string());
  const ShaderPlaces places = randomPlaces(grid, place_count, 8);
  write(folder / "places.bin", places.words());
  write(folder / "lights.bin", lightAt(grid, places));
  const LightBox box = boxOf(grid.tree.frame());
  write(folder / "box.bin", boxWords(box));
  write(folder / "texels.bin", texelNumbers(grid, box));
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("expected a folder and a count of places");
  for (const nlg::ThetaPrecision precision : {nlg::ThetaPrecision::int8, nlg::ThetaPrecision::float16})
    nlg::writeCase(std::filesystem::path(argv[1]) / nlg::thetaPrecisionName(precision), precision, std::stoul(argv[2]));
} catch (const std::exception& error) {
  std::cerr << "shader_cases: " << error.what() << '\n';
  return 1;
}
