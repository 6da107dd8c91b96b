// nlg.LightGrid: a light grid, its probes and its light.
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <vector>

#include "integrations/python/arrays.h"
#include "nlg/look_up.h"

namespace nlg {
namespace {

// Threads look up without Python's lock, and mix() changes what they read. Nobody asks for Python's lock while this one is held.
struct SharedGrid {
  LightGrid grid;
  GridMetadata texts;
  std::shared_mutex light_mutex;
};

std::unique_ptr<SharedGrid> loadGrid(const py::object& source) {
  const FileSource file = sourceOf(source);
  auto shared = std::make_unique<SharedGrid>();
  raiseUnlessOk(file.is_path ? readLightGridFile(std::string(file.text()), &shared->grid, &shared->texts)
                             : parseLightGrid(file.text(), &shared->grid, &shared->texts));
  return shared;
}

py::ssize_t probeCount(const SharedGrid& shared) { return static_cast<py::ssize_t>(shared.grid.tree.probeCount()); }

Rows<double> probePositions(const SharedGrid& shared) {
  Rows<double> positions({probeCount(shared), py::ssize_t{3}});
  for (py::ssize_t p = 0; p < probeCount(shared); ++p) {
    const PositionM at = shared.grid.tree.probePosition(static_cast<size_t>(p));
    std::copy(at.begin(), at.end(), positions.mutable_data(p, 0));
  }
  return positions;
}

// The file's two words for no function are the highest of 32 bits: -1 and -2.
Rows<int64_t> probeFunctions(const SharedGrid& shared) {
  Rows<int64_t> functions(probeCount(shared));
  std::transform(shared.grid.probe_function.begin(), shared.grid.probe_function.end(), functions.mutable_data(),
                 [](uint32_t function) {
                   return function == kFreeSpace ? int64_t{-1} : function == kNoWeight ? int64_t{-2} : int64_t{function};
                 });
  return functions;
}

std::vector<std::string> representations(const SharedGrid& shared) {
  std::vector<std::string> names;
  for (const Representation& representation : shared.grid.representations) names.emplace_back(representationName(representation));
  return names;
}

Rows<uint8_t> functionRepresentations(const SharedGrid& shared) {
  return Rows<uint8_t>(static_cast<py::ssize_t>(shared.grid.functionCount()), shared.grid.function_representation.data());
}

std::vector<std::string> groups(const SharedGrid& shared) {
  std::vector<std::string> names;
  for (const LightGroup& group : shared.grid.groups) names.push_back(group.name);
  return names;
}

py::object light(SharedGrid& shared) {
  if (shared.grid.light.empty()) return py::none();
  Rows<float> rows({probeCount(shared), py::ssize_t{kShCount}, py::ssize_t{kShChannels}});
  float* const values = rows.mutable_data();
  {
    const py::gil_scoped_release released;
    const std::shared_lock looking_up(shared.light_mutex);
    std::copy(shared.grid.light.begin(), shared.grid.light.end(), values);
  }
  return rows;
}

void mix(SharedGrid& shared, const py::object& colours) {
  const Rows<float> rows = rowsOf<float>("colours", colours, {static_cast<py::ssize_t>(shared.grid.groups.size()), 3});
  requireWithin("colours", rows, std::numeric_limits<float>::max());
  std::vector<std::array<float, 3>> of_groups(shared.grid.groups.size());
  for (size_t g = 0; g < of_groups.size(); ++g) std::copy_n(rows.data() + 3 * g, 3, of_groups[g].begin());
  FileResult result;
  {
    const py::gil_scoped_release released;
    const std::unique_lock mixing(shared.light_mutex);
    if (!of_groups.empty()) result = mixLight(of_groups, &shared.grid);
  }
  raiseUnlessOk(result);
}

py::tuple irradiance(SharedGrid& shared, const py::object& positions, const py::object& normals) {
  static_assert(sizeof(PositionM) == 3 * sizeof(double) && sizeof(LightStatus) == 1);
  const Rows<double> positions_m = rowsOf<double>("positions", positions, {kAnyLength, 3});
  const py::ssize_t count = positions_m.shape(0);
  const Rows<float> normals_3 = rowsOf<float>("normals", normals, {count, 3});
  Rows<float> rgb({count, py::ssize_t{3}});
  Rows<uint8_t> status(count);
  const double* const from = positions_m.data();
  float* const to = rgb.mutable_data();
  uint8_t* const status_to = status.mutable_data();
  {
    const py::gil_scoped_release released;
    const std::shared_lock looking_up(shared.light_mutex);
    lookUpIrradiances(shared.grid, reinterpret_cast<const PositionM*>(from), normals_3.data(), static_cast<size_t>(count), to,
                      reinterpret_cast<LightStatus*>(status_to));
  }
  return py::make_tuple(rgb, status);
}

}  // namespace

void addLightGridClass(py::module_& module) {
  py::class_<SharedGrid>(module, "LightGrid", py::is_final(), R"(LightGrid(source): what nlg-bake wrote.

source: the path of a file (str or os.PathLike), or its bytes. Every byte is checked.
Raises OSError where the file cannot be read, ValueError where it is damaged or no light grid.
Any number of threads may use one.)")
      .def(py::init(&loadGrid), py::arg("source"))
      .def_static("__new__", &newOf<&loadGrid>, py::arg("cls"), py::arg("source"))
      .def_property_readonly("probe_positions", &probePositions, "(N, 3) float64, metres: where the N probes stand in the world.")
      .def_property_readonly("probe_functions", &probeFunctions,
                             "(N,) int64: each probe's function, FREE_SPACE (-1: the bare tent) or NO_WEIGHT (-2: in solid).")
      .def_property_readonly("representations", &representations, "list of str: what functions are stored as, \"tent_mlp4\".")
      .def_property_readonly("function_representations", &functionRepresentations,
                             "(F,) uint8: of each of the F functions, its place in representations.")
      .def_property_readonly("groups", &groups, "list of str: the G groups of light that mix() takes; empty where light is one.")
      .def_property_readonly(
          "light", &light,
          "(N, 9, 3) float32: radiance at probes as it is mixed, 9 spherical harmonics of red, green and blue; "
          "None of a grid without light.")
      .def_readonly("metadata", &SharedGrid::texts, "dict of str: the texts of the file, as options and scene.")
      .def("mix", &mix, py::arg("colours"), R"(mix(colours): dims, colours and switches groups of light.

colours: (G, 3) float32, linear factors of red, green and blue in the order of groups, finite; 1 to begin with, 0 of light states after the first.
Look-ups that follow see the sum of the groups, each times its colour.)")
      .def("irradiance", &irradiance, py::arg("positions"), py::arg("normals"), R"(irradiance(positions, normals) -> rgb, status

positions: (n, 3) float64, metres, of the world
normals:   (n, 3) float32, of length 1
rgb:       (n, 3) float32: irradiance, which a diffuse surface multiplies by its albedo over pi; never below 0
status:    (n,) uint8: LIT, FAINT, UNLIT or OUTSIDE

Hand over many positions at once, neighbours beside each other. Other threads of Python run meanwhile.)");
}

}  // namespace nlg
