// Images, vertex colours and transmissive surfaces of a scene, for the page's shaders.
#pragma once

#include "scene/scene.h"
#include "viewer/data_script.h"

namespace nlg {

// Adds what a scene has of these; nothing where it has none:
//   base_places, emissive_places   by vertex, two numbers; vertex_colours: four
//   material_looks                 by material, five numbers: the base image (0: none, else its layer from 1) and its wrapping
//                                  (that of u times 3, plus that of v, as TextureWrap counts), the same of the emissive image,
//                                  and how much light a transmissive surface lets through beside its image's alpha (-1: opaque)
//   images                         layers of side x side texels, rows from the top: sRGB codes and alpha
// facts   images_of: {side, count}
void addLooks(const Scene& scene, DataScript* script);

}  // namespace nlg
