// A room with a window whose walls are 20 cm thick: as solid, or as hollow between two sheets.
#pragma once

#include "tests/scene/built_scenes.h"

namespace nlg {

inline constexpr float kWallM = 0.2f;
inline constexpr glm::vec3 kRoomLow{-2.0f, 0.0f, -1.5f}, kRoomHigh{2.0f, 2.5f, 1.5f};
inline constexpr glm::vec3 kWindowLow{-0.6f, 0.9f, kRoomHigh.z}, kWindowHigh{0.6f, 2.0f, kRoomHigh.z + kWallM};

// A sheet at z from low to high around the window, facing +z or -z.
inline void addSheetWithWindow(Scene& scene, const glm::vec3& low, const glm::vec3& high, float z, bool faces_up) {
  const glm::vec3 &hole = kWindowLow, &end = kWindowHigh;
  const auto add = [&](float x0, float y0, float x1, float y1) {
    const glm::vec3 corner(x0, y0, z), u(x1 - x0, 0, 0), v(0, y1 - y0, 0);
    addQuad(scene, corner, faces_up ? u : v, faces_up ? v : u);
  };
  add(low.x, low.y, hole.x, high.y), add(end.x, low.y, high.x, high.y);
  add(hole.x, low.y, end.x, hole.y), add(hole.x, end.y, end.x, high.y);
}

// All faces look into air, as those of solid walls do; a hollow wall's are double-sided, and say nothing of what lies behind them.
inline Scene windowedRoom(bool is_hollow) {
  Scene scene = sceneOfMaterial(is_hollow);
  const glm::vec3 low = kRoomLow, high = kRoomHigh, out_low = low - kWallM, out_high = high + kWallM;
  const auto addAllButFarSide = [&](const glm::vec3& from, const glm::vec3& to, bool faces_in) {
    const auto sides = boxSides(from, to);
    for (size_t side = 0; side < 5; ++side) {
      const auto& [a, b, c, d] = sides[side];
      addQuad(scene, a, faces_in ? d - a : b - a, faces_in ? b - a : d - a);
    }
  };
  addAllButFarSide(low, high, true);
  addAllButFarSide(out_low, out_high, false);
  addSheetWithWindow(scene, low, high, high.z, false);
  addSheetWithWindow(scene, out_low, out_high, out_high.z, true);
  const glm::vec3 side = kWindowHigh - kWindowLow, x(side.x, 0, 0), y(0, side.y, 0), z(0, 0, side.z);
  addQuad(scene, kWindowLow, z, x), addQuad(scene, kWindowLow, y, z);
  addQuad(scene, kWindowHigh, -x, -z), addQuad(scene, kWindowHigh, -z, -y);
  scene.objects.push_back({"room", 0, static_cast<uint32_t>(scene.triangles.size()), false});
  scene.cavity_m = 0.5;
  return scene;
}

}  // namespace nlg
