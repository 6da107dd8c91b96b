#include "datagen/functions/diffusion_options.h"

namespace nlg {

void describe(DiffusionOptions& o, OptionTable& table) {
  table.group("Weighting functions");
  table.add("diffusion_passes", &o.passes, "diffusion passes, which carry weight round corners", 0, 16);
  table.add("diffusion_sigma", &o.sigma, "standard deviation of the diffusion's Gaussian, as a share of the spacing", 1e-3, 10.0);
  table.add("diffusion_falloff", &o.falloff,
            "falloff of the diffusion: weight fades at points of whose open neighbourhood less than 1/falloff is lit", 0.0, 1e6);
}

}  // namespace nlg
