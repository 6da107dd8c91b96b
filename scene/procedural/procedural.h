// Generates levels from a seed: training scenes that need no files.
//
// Eleven families, each recognisable and each varied by its seed in extent, plan and furnishing. Walls, floors and props are
// closed solids with outward faces (ground and cave shells included), as an engine's brushes and meshes are. Only what kitchens,
// galleries and meeting rooms are fitted with is of sheets in half of the scenes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "scene/procedural/mesh_builder.h"

namespace nlg {

// The families' names:
//   house       rooms with doors and windows on one or two storeys; inner walls of 15 cm
//   apartment   a house whose outer walls are 15 cm thick, and inner ones 10 cm
//   maze        corridors
//   colonnade   halls and arcades
//   stairs      flights and mezzanines
//   clutter     furnished interiors
//   outdoor     uneven ground with buildings, walls and rocks
//   cave
//   kitchen     units and cupboards of boards of 2 cm, or of double-sided sheets, fronts before them, gaps of millimetres to 5 cm
//   gallery     a hall with panels 3 to 8 cm before its walls and before one that stands free
//   meeting     panels, a blind, a sideboard, a table and chairs of plates
// The last three are single rooms with three cameras each.
const std::vector<std::string>& proceduralFamilies();

// The scene of one family and seed; the same bits on every machine for the same arguments. Typically 10 to 30 m across, 3 to 12 m
// high, a few hundred to some ten thousand triangles. Structure (shell, ground) is not movable; props and inner walls are.
// Lit by lamps under the ceilings of furnished rooms, by sky and by sun.
// throws   UsageError when family is not one of proceduralFamilies()
Scene makeProceduralScene(const std::string& family, uint64_t seed);

// Small scenes to look at light with; none is a family to train on. Closed solids with outward faces, as above.
//   cornell:0     the box of that name, 2 x 2 x 2 m inside, open towards +z: red and green walls, two blocks, a lamp above
//   two_rooms:0   two closed rooms of 4 x 2.5 x 4 m with a wall of 10 cm between, a lamp in the left (x < 0) one
//   two_rooms:1   the same with a door between them
//   daylight:0    one closed room of 5 x 3 x 4 m, walls of 20 cm, one window of 1.2 x 1.2 m; outside ground, a sky, and a sun that
//                 falls in
//   daylight:SEED rooms beside daylight, SEED below 26, another kind each: several windows; a door ajar; a cellar; a lamp behind a
//                 wall of a room without light; walls of 5 cm and of 60 cm; walls of sheets around hollows; a street beside a hall;
//                 a skylight; a corridor around a corner; a furnished room with a spot beside a wall; deep reveals; a grille
const std::vector<std::string>& builtInScenes();
// throws   UsageError on a name or seed that is not above
Scene makeBuiltInScene(const std::string& name, uint64_t seed);

// Shared parts of the small scenes. A panel 2 cm thick under a ceiling, which shines downward.
// middle   of its upper side; half: of its sides along x and z
void addPanel(MeshBuilder& mesh, const glm::dvec3& middle, const glm::dvec2& half, uint32_t housing, uint32_t lamp);

// A camera in world coordinates.
void addCamera(Scene& scene, const std::string& name, const glm::dvec3& eye, const glm::dvec3& look, double fov_degrees);

// Rooms beside daylight, each seed another kind of place (procedural.h names them).
inline constexpr uint64_t kDaylightSeeds = 26;
Scene makeDaylight(uint64_t seed);  // seed < kDaylightSeeds

}  // namespace nlg
