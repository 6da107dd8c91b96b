#include "render/irradiance_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "bake/prepared_scene.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr std::string_view kHeader = "x,y,z,nx,ny,nz";
constexpr double kFarthest = 1e7;
constexpr uint64_t kTableStream = 0x7461626c65;

// What lies before the next sign, which is cut off together with it.
std::string_view takeUntil(char sign, std::string_view* text) {
  const size_t end = std::min(text->find(sign), text->size());
  const std::string_view taken = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  return taken;
}

std::string_view takeLine(std::string_view* text) {
  std::string_view line = takeUntil('\n', text);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string quoted(std::string_view text) { return fmt::format("'{}'", text.substr(0, 80)); }

}  // namespace

std::vector<Receiver> receiversFromCsv(const std::string& path, const std::string& text, const glm::dvec3& origin_m) {
  // the header names columns and units; another order would swap positions and normals in silence
  std::string_view rest = text;
  if (const std::string_view header = takeLine(&rest); header != kHeader)
    throw InputError(path, "line 1", std::string(kHeader), quoted(header));
  std::vector<Receiver> receivers;
  for (size_t line_number = 2; !rest.empty(); ++line_number) {
    const std::string_view line = takeLine(&rest);
    const auto refuse = [&](const std::string& expected) {
      return InputError(path, fmt::format("line {}", line_number), expected, quoted(line));
    };
    // columns are counted before numbers are read: the error then says what is wrong
    if (std::count(line.begin(), line.end(), ',') != 5) throw refuse("six numbers with commas between them");
    std::string_view left = line;
    double numbers[6];
    // from_chars takes no locale; NaN fails the comparison
    for (double& number : numbers) {
      const std::string_view word = takeUntil(',', &left);
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || end != word.data() + word.size() || !(std::fabs(number) <= kFarthest))
        throw refuse("numbers from -1e7 to 1e7");
    }
    // normals need not be of length 1, positions become relative to the scene's origin
    const glm::dvec3 normal(numbers[3], numbers[4], numbers[5]);
    if (!(glm::length(normal) > 1e-6)) throw refuse("a normal that is not 0");
    receivers.push_back({glm::dvec3(numbers[0], numbers[1], numbers[2]) - origin_m, glm::vec3(glm::normalize(normal))});
  }
  return receivers;
}

void writeIrradianceTable(const IrradianceRequest& request, const BakeOptions& options) {
  const OwnFiles tables = {"a table of nlg-render",
                           [](std::string_view bytes) { return bytes.starts_with(std::string(kHeader) + ",r,g,b,dr,dg,db"); }};
  refuseToReplace(request.out, {request.scene, request.places}, tables);
  requireOutputFile(request.out);
  const std::string places = readFile(request.places, size_t{1} << 26);
  const SceneSource source = loadLitScene(request.scene, options);
  tellNotes("nlg-render", source);
  const glm::dvec3& origin_m = source.scene.origin_m;
  const std::vector<Receiver> receivers = receiversFromCsv(request.places, places, origin_m);
  // path tracing at each point, with the number of rays that was asked for
  const RayScene rays(source.scene);
  const LightTransport transport(source.scene, rays);
  GatherOptions gather;
  gather.rays = request.rays;
  gather.direct = directLightFromName(options.light_direct);

  // a point on a surface would start behind it, by what its numbers round to
  constexpr double kBeforeSurfaceM = 1e-4;
  // a seed by point: neither threads nor other lines change a row
  std::vector<GatheredIrradiance> gathered(receivers.size());
  parallelFor(receivers.size(), options.threads > 0 ? options.threads : machineThreadCount(), [&](uint64_t i, int) {
    const Receiver& at = receivers[i];
    gathered[i] = transport.gatherIrradiance(at.position_m + kBeforeSurfaceM * glm::dvec3(at.normal), at.normal, gather,
                                             mixSeed(options.seed, kTableStream, i));
  });

  // back to world coordinates, as the points came in
  std::string table = fmt::format("{},r,g,b,dr,dg,db\n", kHeader);
  for (size_t i = 0; i < receivers.size(); ++i) {
    const glm::dvec3 place = origin_m + receivers[i].position_m;
    const glm::vec3 &normal = receivers[i].normal, &light = gathered[i].irradiance, &noise = gathered[i].deviation;
    table += fmt::format("{:.9g},{:.9g},{:.9g},{:.7g},{:.7g},{:.7g},", place.x, place.y, place.z, normal.x, normal.y, normal.z);
    table += fmt::format("{:.7g},{:.7g},{:.7g},{:.3g},{:.3g},{:.3g}\n", light.r, light.g, light.b, noise.r, noise.g, noise.b);
  }
  writeFileAtomically(request.out, table);
}

}  // namespace nlg
