#include "bake/bake_options.h"

#include "bake/policy_options.h"
#include "datagen/shards/shard_job.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {

int threadsOf(const BakeOptions& options) { return options.threads > 0 ? options.threads : machineThreadCount(); }

void takeThetaPrecision(BakeOptions* options) {
  options->policy.theta_precision = thetaPrecisionFromName(options->theta_precision);
}

void describe(BakeOptions& o, OptionTable& table) {
  table.group("Probes");
  table.add("seed", &o.seed, "seed of the shift of the probes' lattice");
  table.group("Generators");
  table.add("representation", &o.representation, "whose shipped weights to take where --weights names none");
  table.group("Probes");
  table.add("spacing_m", &o.spacing_m,
            "finest distance between probes, metres. 0: chosen, half a metre where that takes few probes (docs/guide/bake.md)",
            0.0, 1e5);
  table.add("density_growth", &o.density_growth,
            "how fast probes thin out: their distance from each other over that from the nearest triangle. 0: finest everywhere",
            0.0, 1e3);
  table.add("extent_m", &o.extent_m,
            "where there are probes: --extent-m=x,y,z,X,Y,Z, low and high corner, metres, world coordinates. None: the box that "
            "the file names nlg_extent, or the scene's bounds with headroom and lamps");
  table.add("max_probes", &o.max_probes,
            "refuse a scene that would have more probes before those without air are left out: a million take some 6 GB");
  table.add("align_lattice", &o.align_lattice,
            "do not shift the probes: one lies at the low corner of extent_m, and one at the high corner, whole spacings away");
  table.add("air_only", &o.air_only, "leave out cells that hold no air, and probes that only such cells read");
  table.group("Scene");
  describe(o.reading, table);
  describe(o.scene_light, table);
  table.addRepeated(
      "light_set", &o.light_set,
      "a light of its own in the same grid, for the engine to mix: NAME, this scene as other options light it; NAME=SCENE, "
      "another file of the same geometry; and behind blanks what of these options is otherwise in this set, as "
      "'night=night.glb sky=0 sun=0'. Once for each; the grid begins with the first");
  table.group(kLightGroup);
  table.add("light", &o.light,
            "how probes are lit: solved (least squares over places in air), integrated (by the weighting functions), point (at "
            "the probe) or none (the grid holds weighting functions alone)");
  table.add(
      "light_direct", &o.light_direct,
      "which direct light of lamps and suns probes hold: all, no_suns, none, or reflected (none, and none of shining surfaces "
      "either). Leave out what the engine draws with shadow maps. What surfaces send back of it is always held");
  table.add("light_samples", &o.light_samples,
            "places in the air of every cell at which light is measured; more where a scene would have fewer than 2,048", 1,
            4096);
  table.add("light_rays", &o.light_rays, "rays of every such place", 8, 1 << 20);
  table.add(
      "light_noise", &o.light_noise,
      "relative noise of light at such places above which 64 neighbours get more rays, up to 8 times light_rays. 0: all get "
      "light_rays",
      0.0, 1.0);
  table.add("light_probe_rays", &o.light_probe_rays, "light point: rays of every probe", 8, 1 << 24);
  table.add("light_cache", &o.light_cache,
            "keep what arrives at surfaces, so that each bounce is traced once for all probes. Off: every path by itself");
  table.add("light_pull", &o.light_pull,
            "light solved: how strongly a probe is held at the mean of light under its shares of blends, as a share of the "
            "weight that places read it by",
            0.0, 1e3);
  table.add("light_dark_share", &o.light_dark_share,
            "light solved: errors count as shares of a place's light plus this share of the level's mean light", 1e-6, 1e6);
  table.add("light_outlier", &o.light_outlier,
            "light solved: errors far beyond this many times a place's light, as beside lamps, lose their say", 1e-3, 1e9);
  table.add(
      "thin_error", &o.thin_error,
      "leave out functions and probes that this light does not need, where it adds no more than this to errors, as a share of "
      "light: .03 is hardly seen. Other light may need them: such a grid is not lit anew. 0: none are left out",
      0.0, kMostThinError);
  describe(o.diffusion, table);
  table.group("Weighting functions");
  table.add("duplicate_rms", &o.duplicate_rms,
            "functions that differ by no more than this RMS, in steps of 1/255, share one theta. 0: only the same bytes do", 0.0,
            16.0);
  table.add("duplicate_validity_points", &o.duplicate_validity_points,
            "such functions may differ in validity at no more than so many support points", 0, 8192);
  describePolicy(o.policy, table);
  table.group("Machine");
  table.add(
      "refine_seconds", &o.refine_seconds,
      "time for all refinement, seconds, spent on the worst functions first. 0: as long as it takes; with any other value the "
      "result depends on the machine's speed",
      0.0, 1e9);
  table.group("Light grid's file");
  table.add("theta_precision", &o.theta_precision, "how the file holds theta: float32, float16 or int8");
  table.add("light_error", &o.light_error,
            "what the file's form of light may add to a probe's error, as a share of its light: the fewest bytes a probe that "
            "keep it are taken",
            kLeastLightError, kMostLightError);
  table.add("max_bytes", &o.max_bytes,
            "bytes that the file may have: thin_error becomes as large as that takes. 0: as many as there are", 0.0, 1e15);
  table.group("Machine");
  table.add("simd", &o.simd, "vector instructions to use: sse4, avx2, avx512, … None: the best");
  table.add("threads", &o.threads, "threads. 0: as many as the machine runs at once. The light grid does not depend on them", 0,
            1024);
}

}  // namespace nlg
