// Numbers as scripts, for a page that is opened from a folder: a browser reads no other files there.
//
//     nlgReceive("NAME", {facts}, "bytes of all arrays, one behind another, in base64");
//
// facts.arrays says of each array its kind, as JavaScript names it, its first byte, a multiple of 4, and how many numbers it has.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "light/methods/ddgi.h"
#include "light/methods/method_set.h"
#include "scene/model/scene.h"

namespace nlg {

class DataScript {
 public:
  explicit DataScript(std::string name) : name_(std::move(name)) {}

  nlohmann::ordered_json facts;  // whatever else the page is to know

  void add(const std::string& array, std::span<const float> numbers) { add(array, "Float32Array", numbers); }
  void add(const std::string& array, std::span<const uint32_t> numbers) { add(array, "Uint32Array", numbers); }
  void add(const std::string& array, std::span<const uint8_t> numbers) { add(array, "Uint8Array", numbers); }

  const std::string& name() const { return name_; }
  void rename(std::string name) { name_ = std::move(name); }
  std::string text() const;

 private:
  template <class Number>
  void add(const std::string& array, const char* kind, std::span<const Number> numbers) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    arrays_[array] = {kind, bytes_.size(), numbers.size()};
    const size_t first = bytes_.size();
    bytes_.resize(first + numbers.size_bytes());
    if (!numbers.empty()) std::memcpy(&bytes_[first], numbers.data(), numbers.size_bytes());
  }

  std::string name_, bytes_;
  nlohmann::ordered_json arrays_ = nlohmann::ordered_json::object();
};

// Adds what a scene has of these; nothing where it has none:
//   base_places, emissive_places   by vertex, two numbers; vertex_colours: four
//   material_looks                 by material, five numbers: the base image (0: none, else its layer from 1) and its wrapping
//                                  (that of u times 3, plus that of v, as TextureWrap counts), the same of the emissive image,
//                                  and how much light a transmissive surface lets through beside its image's alpha (-1: opaque)
//   images                         layers of side x side texels, rows from the top: sRGB codes and alpha
// facts   images_of: {side, count}
void addLooks(const Scene& scene, DataScript* script);

// Methods as scripts for the page's shaders. Positions are relative to the scene's origin.

// A light grid: words of a shader grid, and what look_up.glsl is to be compiled for.
// grid      with light, in the scene's coordinates
// throws    InputError on a grid that shaders cannot show
DataScript gridScript(const std::string& name, const LightGrid& grid);

// A blend of the probes around by bare tents, which is the trilinear one, as a light grid without functions.
// light           by probe
// of_all_probes   false: those in solid have no weight
LightGrid trilinearGrid(const ProbeSet& probes, const std::vector<LightSh>& light, bool of_all_probes);

// DDGI as shipped: its tree, as the words of a light grid of bare tents, whose probes are in the order of maps; and a probe's maps,
// kDdgiMapWords each: 1 if it is active, 36 texels of irradiance in 10 bits a channel, 196 pairs of moments in float16.
inline constexpr size_t kDdgiMapWords = 236;  // a multiple of 4; 233 are used
DataScript ddgiScript(const ProbeSet& probes, const DdgiMaps& maps);

// Probes and cells, for drawing.
enum class ProbeKind : uint8_t {
  function,           // in air
  bare_tent,          // nothing is stored of its weights
  function_in_solid,  // its own place is in solid, but not all of what it lights
  empty,              // without weight anywhere
};
// is_in_air   by probe
DataScript probesScript(const LightGrid& grid, const std::vector<uint8_t>& is_in_air);

}  // namespace nlg
