// Levels from a seed: the embedded training scenes, so that the pipeline needs no file from anywhere.
//
// Seven families, each recognisable and each varied by its seed in extent, plan and furnishing. Walls, floors and props are
// closed solids with outward faces (ground and cave shells included), as an engine's brushes and meshes are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/scene/scene.h"

namespace nlg {

// The families' names: house (rooms with doors and windows, one or two storeys), maze (corridors), colonnade (halls, arcades),
// stairs (flights and mezzanines), clutter (furnished interiors), outdoor (uneven ground with buildings, walls and rocks), cave.
const std::vector<std::string>& proceduralFamilies();

// The scene of one family and seed; the same bits on every machine for the same arguments. Typically 10 to 30 m across, 3 to 12 m
// high, a few hundred to some ten thousand triangles. Structure (shell, ground) is not movable; props and inner walls are.
// throws   UsageError when family is not one of proceduralFamilies()
Scene makeProceduralScene(const std::string& family, uint64_t seed);

}  // namespace nlg
