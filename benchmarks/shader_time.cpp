// What look_up.glsl takes on whatever Vulkan device there is, beside bare tents: docs/reference/engines.md has its table.
//
//     bench_shader_time GRID.safetensors [REPETITIONS]
//
// A million places of the grid's tree, in patches of 8 × 8 as pixels of a picture have them, spread evenly over the probes. The
// functions are made up, for what they say does not change the time: a network is its tent, hidden layers drawn at random, and so
// every probe has weight and its light is read. Once all probes have a function, and once those that have one in the grid.
// Each is compiled for its grid, as nlg-export shader hands it out, with the grid's head in a uniform buffer.
// Variants take turns, by the device's own clock; a ratio is the median over the repetitions of a variant's time over that of
// bare tents in the same turn, and milliseconds are the median for the 1920 × 1080 pixels of a picture.
// The texture is resampled from the same tree, 64³ texels around all of its probes, and read at the same places.

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "nlg/shader_grid.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/adam.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/shader_grid/compute_device.h"
#include "tests/runtime_eval/shader_grid/places.h"
#include "tests/runtime_eval/shader_grid/resampled_box.h"

namespace nlg {
namespace {

constexpr int kPatchEdge = 8, kPatches = 1 << 14, kDistinctFunctions = 256, kRepetitions = 11;
constexpr uint32_t kTexels = 64;
constexpr uint32_t kGroups = kPatches;  // of 64 places
constexpr int kPassesATurn = 4;
constexpr double kPixels = 1920.0 * 1080.0;

struct Variant {
  std::string name;
  Representation representation;
  ThetaPrecision precision = ThetaPrecision::int8;
};

std::vector<Variant> variants() {
  const Representation small{RepresentationKind::tent_mlp4},
      large = Representation::tentMlp(), field = Representation::productField(5),
      fine = Representation::code(sampleDictionary(9, 64, 1)), coarse = Representation::code(sampleDictionary(5, 64, 1));
  return {{"`tent_mlp4`, int8", small},
          {"`tent_mlp4`, float16", small, ThetaPrecision::float16},
          {"`tent_mlp`, int8", large},
          {"`tent_mlp`, float16", large, ThetaPrecision::float16},
          {"product fields of 5³ nodes", field, ThetaPrecision::float16},
          {"codes, bricks of 9³ nodes", fine},
          {"codes, bricks of 5³ nodes", coarse}};
}

Theta madeUpTheta(const Variant& variant, uint64_t seed) {
  Theta theta = randomTheta(variant.representation, seed);
  if (variant.representation.isNetwork()) {
    const NetworkShape& shape = variant.representation.shape();
    std::fill(&theta[static_cast<size_t>(shape.w3())], &theta[static_cast<size_t>(shape.b3())], 0.0f);
    theta[static_cast<size_t>(shape.b3())] = 1.0f;
  }
  if (!roundTheta(variant.representation, variant.precision, theta.data()))
    throw std::runtime_error("a theta beyond its precision");
  return theta;
}

// The grid's tree and light with functions of a variant; without one, bare tents alone.
LightGrid equipped(const LightGrid& grid, const Variant* variant, bool everywhere) {
  LightGrid result;
  result.tree = grid.tree;
  result.light = grid.light;
  result.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  if (variant == nullptr) return result;
  result.representations = {variant->representation};
  for (uint64_t i = 0; i < kDistinctFunctions; ++i) result.addFunction(0, madeUpTheta(*variant, i).data());
  for (size_t probe = 0; probe < result.probe_function.size(); ++probe) {
    const uint32_t own = grid.probe_function[probe];
    result.probe_function[probe] = everywhere || own < kNoWeight ? static_cast<uint32_t>(probe) % kDistinctFunctions : own;
  }
  return result;
}

// Patches a quarter of a spacing wide.
ShaderPlaces patches(const LightGrid& grid) {
  // the seed is fixed: all devices look up the same positions
  Random random(8);
  ShaderPlaces places;
  for (int patch = 0; patch < kPatches; ++patch) {
    // anywhere in the support of a probe, facing one axis
    const size_t probe = random.below(static_cast<uint32_t>(grid.tree.probeCount()));
    const double spacing_m = grid.tree.probeSpacing(probe), step_m = spacing_m / (4 * kPatchEdge);
    PositionM low = grid.tree.probePosition(probe);
    for (double& value : low) value += spacing_m * random.uniform(-1.0, 1.0);
    const size_t facing = random.below(3);
    std::array<float, 3> normal{};
    normal[facing] = 1.0f;
    // neighbours of a patch lie in neighbouring invocations, as pixels of a surface do
    for (int i = 0; i < kPatchEdge * kPatchEdge; ++i) {
      PositionM at = low;
      const int row = i / kPatchEdge;
      at[(facing + 1) % 3] += step_m * (i % kPatchEdge);
      at[(facing + 2) % 3] += step_m * row;
      places.positions_m.push_back(asFloats(at));
      places.normals.push_back(normal);
    }
  }
  return places;
}

LightBox boxAround(const LightGrid& grid) {
  LightBox box;
  box.low_m = box.high_m = grid.tree.probePosition(0);
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    const PositionM at = grid.tree.probePosition(probe);
    for (size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] = std::min(box.low_m[axis], at[axis]);
      box.high_m[axis] = std::max(box.high_m[axis], at[axis]);
    }
  }
  box.texel_count = {kTexels, kTexels, kTexels};
  return box;
}

class Timer {
 public:
  Timer(const ComputeDevice& device, const LightGrid& grid)
      : device_(device), lights_(device.makeBuffer(size_t{4} * kGroups * 64)) {
    const ShaderPlaces places = patches(grid);
    places_ = device.makeBuffer(places.words());
    addLookUp("bare tents", equipped(grid, nullptr, false));
    addLookUp("bare tents, the head in the grid's buffer", equipped(grid, nullptr, false), false);
    for (const Variant& variant : variants()) {
      addLookUp(variant.name + ", all probes", equipped(grid, &variant, true));
      addLookUp(variant.name + ", as in the grid", equipped(grid, &variant, false));
    }
    addTexture(equipped(grid, nullptr, false), places);
  }

  void measure(int repetitions) {
    // until a card's clock is up
    const auto begin = std::chrono::steady_clock::now();
    do {
      for (const Run& run : runs_) timeOf(run);
    } while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
    for (int r = 0; r < repetitions; ++r) {
      const double tents = timeOf(runs_[0]);
      for (Run& run : runs_) {
        const double time_s = timeOf(run);
        run.ratios.push_back(time_s / tents);
        run.picture_ms.push_back(1e3 * time_s * kPixels / (kPatches * kPatchEdge * kPatchEdge));
      }
    }
  }

  void print() {
    std::printf("| | ms a picture | time, of that of bare tents | quartiles |\n|---|---|---|---|\n");
    for (Run& run : runs_) {
      const auto quartile = [](std::vector<double>& values, size_t quarter) {
        std::sort(values.begin(), values.end());
        return values[(values.size() - 1) * quarter / 4];
      };
      std::printf("| %s | %.3g | %.2f | %.2f … %.2f |\n", run.name.c_str(), quartile(run.picture_ms, 2), quartile(run.ratios, 2),
                  quartile(run.ratios, 1), quartile(run.ratios, 3));
    }
  }

 private:
  using Binding = ComputeDevice::Binding;
  struct Run {
    std::string name;
    ComputeDevice::Buffer input;  // the grid's words, or places in the box
    ComputeDevice::Buffer head;
    ComputeDevice::Pass pass;
    std::vector<double> ratios, picture_ms;
  };

  static std::string spirvPath(const std::string& name) { return NLG_SPIRV_FOLDER + name + ".spv"; }

  static ShaderGrid pack(const LightGrid& grid) {
    ShaderGrid packed;
    const FileResult result = packShaderGrid(grid, &packed);
    if (!result.ok()) throw std::runtime_error(result.detail);
    return packed;
  }

  void addLookUp(const std::string& name, const LightGrid& grid, bool uniform_head = true) {
    ShaderGrid packed = pack(grid);
    const std::vector<uint32_t> head(packed.words.begin(), packed.words.begin() + 4 * packed.header_count);
    Run run{name, device_.makeBuffer(packed.words), device_.makeBuffer(head), {}, {}, {}};
    std::vector<ComputeDevice::Binding> bindings{Binding::storage(run.input), Binding::storage(places_),
                                                 Binding::storage(lights_)};
    if (uniform_head) {
      packed.defines.push_back("NLG_UNIFORM_HEAD " + std::to_string(packed.header_count));
      bindings.push_back(Binding::uniform(run.head));
    }
    run.pass = device_.makePass(compiled(packed.defines), bindings);
    runs_.push_back(std::move(run));
  }

  // look_up.comp as SPIR-V; returns its path
  static std::string compiled(const std::vector<std::string>& defines) {
    const std::string path = (std::filesystem::temp_directory_path() / "nlg_shader_time.spv").string();
    std::string command = NLG_GLSLANG " --quiet -V --target-env vulkan1.1 -I" NLG_SOURCES " -o " + path;
    for (const std::string& define : defines) {
      std::string assigned = define;
      if (const size_t space = assigned.find(' '); space != std::string::npos) assigned[space] = '=';
      command += " '-D" + assigned + "'";
    }
    if (std::system((command + " " NLG_SOURCES "/tests/runtime_eval/shader_grid/look_up.comp").c_str()) != 0)
      throw std::runtime_error("glslang does not compile look_up.comp");
    return path;
  }

  void addTexture(const LightGrid& grid, const ShaderPlaces& places) {
    const LightBox box = boxAround(grid);
    texture_ = device_.makeImage({kTexels, kTexels, static_cast<uint32_t>(kSlabs) * kTexels});
    const ComputeDevice::Buffer words = device_.makeBuffer(pack(grid).words), box_words = device_.makeBuffer(boxWords(box));
    device_.run(device_.makePass(spirvPath("resample"),
                                 {Binding::storage(words), Binding::uniform(box_words), Binding::written(texture_)}),
                boxGroups(box));
    std::vector<uint32_t> shares = places.words();
    for (size_t i = 0; i < places.count(); ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        const double share = (places.positions_m[i][axis] - box.low_m[axis]) / (box.high_m[axis] - box.low_m[axis]);
        shares[8 * i + axis] = std::bit_cast<uint32_t>(static_cast<float>(share));
      }
    }
    Run run{"a resampled texture", device_.makeBuffer(shares), {}, {}, {}, {}};
    run.pass = device_.makePass(spirvPath("resampled"),
                                {Binding::sampled(texture_), Binding::storage(run.input), Binding::storage(lights_)});
    runs_.push_back(std::move(run));
  }

  double timeOf(const Run& run) const { return device_.timeOf(run.pass, {kGroups, 1, 1}, kPassesATurn); }

  const ComputeDevice& device_;
  ComputeDevice::Buffer lights_, places_;
  ComputeDevice::Image texture_;
  std::vector<Run> runs_;
};

void run(const std::string& path, int repetitions) {
  const std::optional<ComputeDevice> device = ComputeDevice::find();
  if (!device) throw std::runtime_error("no Vulkan device, not even a software one (Debian: mesa-vulkan-drivers)");
  LightGrid grid;
  GridMetadata metadata;
  const FileResult result = readLightGridFile(path, &grid, &metadata);
  if (!result.ok()) throw std::runtime_error(path + ": " + fileStatusName(result.status) + ": " + result.detail);
  const auto with_function =
      std::count_if(grid.probe_function.begin(), grid.probe_function.end(), [](uint32_t f) { return f < kNoWeight; });
  std::printf("On %s, %d places, %d turns; of %zu probes %zd have a function in the grid.\n\n", device->name().c_str(),
              kPatches * kPatchEdge * kPatchEdge, repetitions, grid.tree.probeCount(), with_function);
  Timer timer(*device, grid);
  timer.measure(repetitions);
  timer.print();
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::runtime_error("expected a light grid (.safetensors), and how many repetitions");
  const int repetitions = argc == 3 ? std::stoi(argv[2]) : nlg::kRepetitions;
  if (repetitions < 1) throw std::runtime_error("expected one repetition at least");
  nlg::run(argv[1], repetitions);
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_shader_time: %s\n", error.what());
  return 1;
}
