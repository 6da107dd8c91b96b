#include "bake/bake_options.h"

#include "datagen/weighting/weighting_builder.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {

int threadsOf(const BakeOptions& options) { return options.threads > 0 ? options.threads : machineThreadCount(); }

void takeThetaPrecision(BakeOptions* options) {
  options->policy.theta_precision = thetaPrecisionFromName(options->theta_precision);
}

void describe(BakeOptions& o, OptionTable& table) {
  table.group("Probes");
  table.add("seed", &o.seed, "seed of the probe lattice's offset");
  table.group("Generators");
  table.add("representation", &o.representation, "representations whose shipped weights are used when --weights is not given");
  table.group("Probes");
  table.add("spacing_m", &o.spacing_m,
            "finest probe spacing, metres. 0: chosen by the number of probes, 0.5 for small scenes (docs/guide/bake.md)", 0.0,
            1e5);
  table.add("density_growth", &o.density_growth,
            "ratio of probe spacing to the distance from the nearest triangle: larger values thin probes out faster. 0: finest "
            "spacing everywhere",
            0.0, 1e3);
  table.add("extent_m", &o.extent_m,
            "box that probes fill: --extent-m=x,y,z,X,Y,Z, low and high corner, metres, world coordinates. None: the file's "
            "nlg_extent, or the scene's bounds with headroom and lamps");
  table.add("max_probes", &o.max_probes,
            "maximum number of probes, counted before those without air are left out; scenes with more are refused. A million "
            "take about 6 GB");
  table.add(
      "align_lattice", &o.align_lattice,
      "put a probe at the low corner of extent_m, and the last ones a whole number of spacings away, instead of a random offset");
  table.add("air_only", &o.air_only, "leave out cells without air, and probes that only such cells read");
  table.add(
      "draft", &o.draft,
      "a fast look: functions are predicted from 1,024 rays a probe, without diffusion, fits and check. Needs weights that read "
      "samples");
  table.group("Scene");
  describe(o.reading, table);
  describe(o.scene_light, table);
  table.group(kLightGroup);
  table.add("light", &o.light,
            "how probe light is computed: solved (least squares over sample points in air), integrated (over the weighting "
            "function), point (at the probe), or none (the grid holds weighting functions only)",
            {"solved", "integrated", "point", "none"});
  table.add("light_direct", &o.light_direct,
            "direct light that probes hold: all; no_suns; none, neither of lamps nor of suns; or reflected, none of emissive "
            "surfaces either. Leave out what the engine draws with shadow maps. Reflected light is always held",
            {"all", "no_suns", "none", "reflected"});
  table.add("light_samples", &o.light_samples,
            "sample points in air per cell at which light is measured; raised in scenes that would have fewer than 2,048 in all",
            1, 4096);
  table.add("light_rays", &o.light_rays,
            "rays per sample point, at least 8. 0: 64 to 512, about 16 million in all where these limits allow", 0, 1 << 20);
  table.add("light_probe_rays", &o.light_probe_rays, "rays per probe, with --light point", 8, 1 << 24);
  table.add("light_cache", &o.light_cache,
            "cache irradiance at surfaces, so that each bounce is traced once for all probes. Off: every path is traced in full");
  table.add("light_pull", &o.light_pull,
            "regularisation of solved light towards the probe's mean light, as a share of the weight with which sample points "
            "read the probe",
            0.0, 1e3);
  table.add("light_dark_share", &o.light_dark_share,
            "constant in the relative error that solved light minimises, as a share of the level's mean light: larger values "
            "weigh dark points less",
            1e-6, 1e6);
  table.add("light_outlier", &o.light_outlier,
            "relative error beyond which sample points are down-weighted in solved light (Cauchy), for instance beside lamps",
            1e-3, 1e9);
  table.add("thin_error", &o.thin_error,
            "maximum error added by thinning, as a share of light: functions and probes that this light does not need are left "
            "out. .03 is hardly visible. A thinned grid cannot be relit. 0: no thinning",
            0.0, kMostThinError);
  describe(o.diffusion, table);
  table.group("Weighting functions");
  table.add("duplicate_rms", &o.duplicate_rms,
            "maximum RMS difference, in steps of 1/255, at which two functions share one theta. 0: only identical functions do",
            0.0, 16.0);
  table.add("duplicate_validity_points", &o.duplicate_validity_points,
            "maximum number of support points at which two functions that count as one may differ in validity", 0, 8192);
  describePolicy(o.policy, table);
  table.group("Machine");
  table.add("refine_seconds", &o.refine_seconds,
            "time limit of all refinement, seconds; the worst functions come first. 0: no limit. With a limit the result depends "
            "on the machine's speed",
            0.0, 1e9);
  table.group("Light grid's file");
  table.add("theta_precision", &o.theta_precision, "number format of theta in the file: float32, float16 or int8",
            {"float32", "float16", "int8"});
  table.add(
      "light_error", &o.light_error,
      "maximum error that rounding of light adds to a probe, as a share of its light: the smallest encoding within it is used",
      kLeastLightError, kMostLightError);
  table.add("max_bytes", &o.max_bytes, "maximum size of the file, bytes: thin_error is raised until the file fits. 0: no limit",
            0.0, 1e15);
  table.group("Machine");
  table.add("simd", &o.simd,
            "vector instructions: avx512, avx2, sse4, ssse3, neon or scalar. None: the best that the processor has");
  table.add("threads", &o.threads, "number of threads. 0: one per hardware thread. The light grid does not depend on it", 0,
            1024);
}

}  // namespace nlg
