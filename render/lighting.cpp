#include "render/lighting.h"

#include <bit>
#include <vector>

#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Noise of neighbouring pixels must not be alike, and a receiver's must not depend on where in a picture it stands.
uint64_t seedOf(const Receiver& receiver, uint64_t seed) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  const glm::dvec3& p = receiver.position_m;
  const glm::dvec3 n(receiver.normal);
  return mixSeed(mixSeed(bits(p.x), bits(p.y), bits(p.z), seed), bits(n.x), bits(n.y), bits(n.z));
}

PositionM worldPosition(const Receiver& receiver, const glm::dvec3& origin_m) {
  const glm::dvec3 world = origin_m + receiver.position_m;
  return {world.x, world.y, world.z};
}

bool isLit(LightStatus status, const glm::vec3& irradiance) {
  return status == LightStatus::lit || status == LightStatus::faint || irradiance != glm::vec3(0.0f);
}

}  // namespace

Lighting truthLighting(const LightTransport& transport, const GatherOptions& options, uint64_t seed) {
  return {"truth", [&transport, options, seed](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              const GatheredIrradiance gathered =
                  transport.gatherIrradiance(receiver.position_m, receiver.normal, options, seedOf(receiver, seed));
              *received++ = {gathered.irradiance, gathered.deviation, true};
            }
          }};
}

Lighting gridLighting(const LightGrid& grid, const glm::dvec3& origin_m) {
  return {"grid", [&grid, origin_m](std::span<const Receiver> receivers, ReceivedLight* received) {
            // of all receivers at once: what is near together is looked up together
            const size_t count = receivers.size();
            std::vector<PositionM> positions_m(count);
            std::vector<glm::vec3> normals(count), irradiance(count);
            std::vector<LightStatus> status(count);
            for (size_t i = 0; i < count; ++i) {
              positions_m[i] = worldPosition(receivers[i], origin_m);
              normals[i] = receivers[i].normal;
            }
            lookUpIrradiances(grid, positions_m.data(), &normals.data()->x, count, &irradiance.data()->x, status.data());
            for (size_t i = 0; i < count; ++i) received[i] = {irradiance[i], glm::vec3(0.0f), isLit(status[i], irradiance[i])};
          }};
}

Lighting probeShareLighting(const LightGrid& grid, const glm::dvec3& origin_m, uint32_t probe) {
  return {"weights", [&grid, origin_m, probe](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              ProbeWeights shares;
              ReceivedLight& light = *received++;
              light = {};
              lookUpShares(grid, worldPosition(receiver, origin_m), &shares);
              light.is_lit = shares.count > 0;
              for (int i = 0; i < shares.count; ++i) {
                if (shares.probe[i] == probe) light.irradiance = glm::vec3(shares.weight[i]);
              }
            }
          }};
}

Lighting measuredLighting(const std::string& name, const LightMethod& method) {
  return {name, [&method](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              const LightAnswer answer = method.irradiance_at(receiver.position_m, receiver.normal);
              const bool is_lit = answer.reach == Reach::lit || answer.reach == Reach::fallback;
              *received++ = {answer.irradiance, glm::vec3(0.0f), is_lit || answer.irradiance != glm::vec3(0.0f)};
            }
          }};
}

}  // namespace nlg
