#include "bake/bake_options.h"

#include "bake/policy_options.h"
#include "datagen/shards/shard_job.h"
#include "tool/error.h"

namespace nlg {

LightForm lightFormFromName(const std::string& name) {
  LightForm form = LightForm::none;
  if (!findLightForm(name, &form) || form == LightForm::none)
    throw UsageError("light_form", "sh2_8bit, sh2_float16, zh3_float16 or sh1_float16", "'" + name + "'");
  return form;
}

void takeThetaPrecision(BakeOptions* options) {
  options->policy.theta_precision = thetaPrecisionFromName(options->theta_precision);
}

void describe(BakeOptions& o, OptionTable& table) {
  table.add("seed", &o.seed, "seed of the shift of the probes' lattice");
  table.add("representation", &o.representation, "whose shipped weights to take when --weights names none");
  table.add("spacing_m", &o.spacing_m, "finest probe spacing, metres", 1e-4, 1e5);
  table.add("density_growth", &o.density_growth, "probe spacing over distance from the nearest triangle; 0: finest everywhere",
            0.0, 1e3);
  table.add(
      "extent_m", &o.extent_m,
      "where there are probes, --extent-m=x,y,z,X,Y,Z: low and high corner, metres, world coordinates; none: the scene's bounds");
  table.add("align_lattice", &o.align_lattice,
            "no random shift of the probes: the low corner of extent_m is one, and the high corner, whole spacings away, too");
  table.add("air_only", &o.air_only, "leave out cells that hold no air, and the probes that only they read");
  describe(o.reading, table);
  describe(o.scene_light, table);
  table.add(
      "light", &o.light,
      "how probes are lit: solved (least squares over places in air), integrated (the talk's way), point (at the probe), or "
      "none: the grid holds weighting functions alone");
  table.add(
      "light_direct", &o.light_direct,
      "what probes hold of the direct light of lamps and suns: all, no_suns or none, for engines that draw these with shadow "
      "maps; what such light sends back from surfaces is always held");
  table.add("light_places", &o.light_places,
            "places in air of every cell at which light is measured; more where those would be fewer than 2,048 in a scene", 1,
            4096);
  table.add("light_rays", &o.light_rays, "rays of every such place", 8, 1 << 20);
  table.add("light_probe_rays", &o.light_probe_rays, "rays of every probe, with light point", 8, 1 << 24);
  table.add("light_cache", &o.light_cache,
            "keep what arrives at surfaces, so that each bounce is traced once for all probes; off: every path by itself");
  table.add("light_pull", &o.light_pull,
            "solved: how strongly a probe is held at its integrated light, in shares of what places say of it", 0.0, 1e3);
  table.add("light_dark_share", &o.light_dark_share,
            "solved: errors count as shares of a place's light and this share of the level's mean light", 1e-6, 1e6);
  table.add("light_outlier", &o.light_outlier,
            "solved: errors far beyond this share of the level's mean light, as beside lamps, lose their say", 1e-3, 1e9);
  describe(o.diffusion, table);
  table.add("duplicate_rms", &o.duplicate_rms,
            "functions that differ by no more than this RMS, in steps of 1/255, share one theta; 0: the same bytes", 0.0, 16.0);
  table.add("duplicate_validity_points", &o.duplicate_validity_points,
            "and whose validity differs in no more than so many support points", 0, 8192);
  describePolicy(o.policy, table);
  table.add("refine_seconds", &o.refine_seconds,
            "time for all refinement, spent on the worst functions first; 0: as long as it takes, the only setting whose result "
            "does not depend on the machine's speed",
            0.0, 1e9);
  table.add("generator_precision", &o.generator_precision, "float32, or int16: fixed point, faster");
  table.add("theta_precision", &o.theta_precision, "float32, float16 or int8, in the light grid's file");
  table.add("light_form", &o.light_form,
            "how the file holds light: sh2_8bit (32 bytes a probe), sh2_float16 (54), zh3_float16 (30), sh1_float16 (24)");
  table.add("simd", &o.simd, "vector instructions to use (sse4, avx2, avx512, …); none: the best");
  table.add("threads", &o.threads, "threads; 0: as many as the machine runs at once. The light grid does not depend on them", 0,
            1024);
}

}  // namespace nlg
