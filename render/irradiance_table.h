// Ground truth of irradiance at sample points of a file, for comparisons with another renderer.
#pragma once

#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "render/sight.h"

namespace nlg {

struct IrradianceRequest {
  std::string scene, places, out;
  int rays = 4096;  // of every place; >= 8
};

// The places of a table of comma-separated values: a line `x,y,z,nx,ny,nz`, then one of such numbers a place: where it is, world,
// metres, within 10^7 m, and its normal, of any length.
// path       for errors
// origin_m   the scene's, which receivers are relative to
// throws     InputError naming the line
std::vector<Receiver> receiversFromCsv(const std::string& path, const std::string& text, const glm::dvec3& origin_m);

// Writes request.out: the table of the places as above, normals of length 1, with the columns r,g,b of irradiance and dr,dg,db of its
// noise's standard deviation. The same bytes on any number of threads, which with seed and light_direct come from `options`.
// throws   UsageError, InputError, OutputError
void writeIrradianceTable(const IrradianceRequest& request, const BakeOptions& options);

}  // namespace nlg
