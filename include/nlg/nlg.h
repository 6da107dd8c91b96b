/* The library in C, for engines in other languages. At bake time it predicts, fits and checks theta from weighting functions, and
 * evaluates theta at any point. In the game it looks up irradiance in a light grid. See examples/bake_minimal.c.
 *
 * C11. These functions throw nothing and keep no state, except the support pattern, which the first call that needs it computes
 * (safe from any thread). Formats: docs/reference/formats.md.
 *
 * Threads   Generators and light grids are constant after loading: any number of threads may share them. Each thread needs its
 *           own scratch.
 * Memory    nlg_generate, nlg_evaluate, nlg_check_theta and the look-ups allocate nothing and cannot fail. nlg_make_theta
 *           allocates. Every handle is freed by its own function; a null handle may be freed.
 * Pointers  Must not be null unless it is said. Arrays need no alignment. Every function checks: with a null pointer, functions
 *           that return a status return NLG_INVALID_ARGUMENT; those that return a count, a text or a pointer return 0 or null;
 *           nlg_check_theta returns NaN and 0 for passes; nlg_irradiance returns NLG_OUTSIDE; the others write nothing.
 */
#ifndef NLG_C_API_NLG_H_
#define NLG_C_API_NLG_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define NLG_SUPPORT_POINT_COUNT 8192 /* P */

/* In C an enumeration can hold any int; in C++ only if its type is declared. */
#ifdef __cplusplus
#define NLG_OF_INT : int
#else
#define NLG_OF_INT
#endif

/* Why a call failed. Values never change; later versions may add some. */
typedef enum nlg_status NLG_OF_INT {
  NLG_OK = 0,
  NLG_CANNOT_OPEN = 1,       /* the system refused, or it is not a regular file */
  NLG_CANNOT_READ = 2,       /* the system refused, or the file is too large: weights above 1 GiB, grids above 16 GiB */
  NLG_TOO_SHORT = 3,         /* no header length, or fewer bytes than the tensors need */
  NLG_HEADER_TOO_LARGE = 4,  /* header above 1 MiB or past the end of the file */
  NLG_HEADER_MALFORMED = 5,  /* no safetensors header */
  NLG_TENSOR_MALFORMED = 6,  /* another dtype, shape and bytes disagree, overlap, hole, misaligned, bytes behind the last one */
  NLG_TENSOR_MISSING = 7,    /* a required tensor or metadata key is not there */
  NLG_TENSOR_UNEXPECTED = 8, /* a tensor of another shape than required */
  NLG_VALUE_NOT_FINITE = 9,
  NLG_VALUE_OUT_OF_RANGE = 10,
  NLG_VERSION_UNKNOWN = 11,
  NLG_PATTERN_UNKNOWN = 12,  /* made for another support pattern */
  NLG_SIMD_UNAVAILABLE = 13, /* the environment variable NLG_SIMD names a target that this build or machine does not have */
  NLG_DIGEST_MISMATCH = 14,  /* the bytes do not match the file's SHA-256: it is damaged */
  NLG_OUT_OF_MEMORY = 100,
  NLG_INVALID_ARGUMENT = 101 /* a null pointer, a scratch of another generator */
} nlg_status;

/* Returns a short English name for messages, as "tensor_missing"; "unknown" for a value that is no status. It is never freed. */
const char* nlg_status_name(nlg_status status);

/* A generator: a loaded weights file. */
typedef struct nlg_generator nlg_generator;

/* Working memory of one thread for one generator, with the options of the policy. */
typedef struct nlg_scratch nlg_scratch;

/* Loads a weights file, from a path or from bytes that are needed only during the call. Every byte is verified.
 *
 * path          as "weights/tent_mlp4.safetensors"; UTF-8 on Windows
 * bytes         may be null if byte_count is 0
 * generator     receives the handle; null on failure
 * detail        receives one line of UTF-8, truncated to detail_size with a final zero: on failure where and why, on success an
 *               empty text. May be null if detail_size is 0 */
nlg_status nlg_generator_load(const char* path, nlg_generator** generator, char* detail, size_t detail_size);
nlg_status nlg_generator_load_bytes(const void* bytes, size_t byte_count, nlg_generator** generator, char* detail,
                                    size_t detail_size);
void nlg_generator_free(nlg_generator* generator);

/* Returns the representation that theta is of, as "tent_mlp4" (docs/reference/formats.md). It is never freed. */
const char* nlg_representation_name(const nlg_generator* generator);
/* Returns the slope of LeakyReLU in networks, in (0, 1), which evaluation in the game needs. */
float nlg_representation_slope(const nlg_generator* generator);
/* Returns D, the number of floats of one theta, as 21. */
size_t nlg_theta_count(const nlg_generator* generator);
/* Returns 1 if the network reads samples, so that nlg_generate_from_samples serves; 0 if it reads coefficients of whole functions. */
int nlg_reads_samples(const nlg_generator* generator);
/* Returns D floats, valid as long as the generator: the start of fits that use no prediction. */
const float* nlg_theta0(const nlg_generator* generator);

/* Gets the support points, at which an engine samples its functions.
 *
 * points_xyz    receives P x 3 floats in local coordinates, (-1, 1), one unit being one probe spacing; they are never freed
 * pattern_hash  receives the hash that files for these points contain
 * returns       NLG_OK or NLG_OUT_OF_MEMORY; after a generator was loaded always NLG_OK */
nlg_status nlg_support_pattern(const float** points_xyz, uint64_t* pattern_hash);
/* Returns which support point a sample point is, 0 to 1023: nlg_generate_from_samples reads no others. */
size_t nlg_sample_point(size_t sample);

/* The number format that nlg_make_theta rounds theta to. It returns the rounded numbers as floats. */
typedef enum nlg_theta_precision NLG_OF_INT {
  NLG_THETA_FLOAT32 = 0,
  NLG_THETA_FLOAT16 = 1,
  NLG_THETA_INT8 = 2
} nlg_theta_precision;

/* Options of the policy, which computes from a function the theta that is stored. Its stages are in policy.h; meaning, default
 * and range of each option in policy_options.def. None may be NaN. A scratch has one generator, so that options of the choice
 * among several are left out. */
typedef struct nlg_policy_options {
#define NLG_CHOICE_OPTION(type, name, value, low, high, help)
#define NLG_POLICY_OPTION(type, name, value, low, high, help) type name;
#include "policy_options.def"          /* beside this header, whatever its include path */
  nlg_theta_precision theta_precision; /* NLG_THETA_INT8 */
} nlg_policy_options;

/* Returns the defaults, which are those of nlg-bake. */
nlg_policy_options nlg_default_policy(void);

/* Returns the name of the first option that is out of its range, as "refine_first_steps"; null if all are valid. It is never
 * freed. */
const char* nlg_policy_out_of_range(const nlg_policy_options* options);

/* Makes working memory for a generator.
 *
 * options   of nlg_make_theta and nlg_check_theta with this scratch; null: the defaults
 * scratch   receives the handle; null on failure. The generator must outlive it
 * returns   NLG_OK; NLG_OUT_OF_MEMORY; or NLG_VALUE_OUT_OF_RANGE for an option that nlg_policy_out_of_range names */
nlg_status nlg_scratch_create(const nlg_generator* generator, const nlg_policy_options* options, nlg_scratch** scratch);
void nlg_scratch_free(nlg_scratch* scratch);

/* Predicts theta of `count` functions. The theta of a function does not depend on the other functions of the call. It is neither
 * checked nor fitted: nlg_make_theta does both.
 *
 * phi       count x P bytes, round(255 phi) at the support points in their order; 0 at points in solid
 * validity  count x P / 8 bytes: bit i of byte b is point 8 b + i, 1 where it lies in air
 * theta     count x D floats, overwritten
 * scratch   made for this generator */
void nlg_generate(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, size_t count, float* theta,
                  nlg_scratch* scratch);

/* The same of what a probe sees at the sample points, without phi: 1024 rays, as when a door has moved. nlg_sample_point
 * says where they are.
 *
 * seen      count x 128 bytes: bit i of byte b is sample point 8 b + i, 1 where the segment from the probe meets no triangle
 * validity  likewise: 1 where the point lies in air; every seen point does
 * theta     count x D floats, overwritten; left as they were by a generator of coefficients (nlg_reads_samples is 0) */
void nlg_generate_from_samples(const nlg_generator* generator, const uint8_t* seen, const uint8_t* validity, size_t count,
                               float* theta, nlg_scratch* scratch);

/* Evaluates the function of one theta at `count` points.
 *
 * theta    D floats, all finite
 * x, y, z  count floats each, all finite: local coordinates in (-1, 1); outside them values have no meaning
 * values   count floats, overwritten; not clamped to [0, 1]
 * scratch  made for this generator */
void nlg_evaluate(const nlg_generator* generator, const float* theta, size_t count, const float* x, const float* y,
                  const float* z, float* values, nlg_scratch* scratch);

/* Errors of one theta against its function, over all valid support points. */
typedef struct nlg_check {
  double rmse;       /* in units of phi, as 0.004; not finite if theta is not */
  double blend_rmse; /* root of the loss, which fits minimise; likewise */
  double leak_mean;  /* mean |value| over valid points whose phi is 0 */
  double leak_share; /* share of these points that leak */
  int passes;        /* 1: theta is good enough to be stored; else 0 */
} nlg_check;

/* Checks one theta of this generator's representation. Allocates nothing and cannot fail.
 *
 * phi        P bytes, as for nlg_make_theta
 * validity   P / 8 bytes, likewise
 * blend_sum  P bytes or null, likewise
 * theta      D floats
 * scratch    made for this generator, with the options of the check */
nlg_check nlg_check_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          const float* theta, nlg_scratch* scratch);

/* The policy's result for one function. */
typedef struct nlg_made {
  int has_theta;       /* 0: the bare tent is good enough, and theta is all zeros */
  int took_fit;        /* 1: steps of Adam or Levenberg-Marquardt ran */
  const char* ended;   /* the last stage that changed theta, as "network", "last_layer" or "refinement"; never freed */
  nlg_check network;   /* after one pass of the network */
  nlg_check corrected; /* after the exact last layer */
  nlg_check fitted;    /* after every fit, the refinement included */
  nlg_check stored;    /* after rounding: of the theta that is returned */
  double elapsed_us;   /* time of this function, microseconds of a steady clock */
} nlg_made;

/* Runs the whole policy: bare tent, network, check, exact last layer, short fits, refinement of what fails, rounding. It takes
 * tens of microseconds for most functions and milliseconds for the hardest (docs/reference/results.md). The theta of a function
 * does not depend on the other functions of the call.
 *
 * phi        count x P bytes, round(255 phi) at the support points in their order; 0 at points in solid
 * validity   count x P / 8 bytes; bit i of byte b is 1 if point 8 b + i lies outside solid
 * blend_sum  count x P bytes, round(255 min(1, S)): S is the sum, at the point, of the functions of all probes of the grid's cell
 *            around it. Fits keep the weight of a probe where few others see the point (docs/theory/math.md §4). Null: S is taken
 *            as 1, as if other probes saw all that this one sees; points that only this one sees may then turn black
 * theta      count x D floats, overwritten
 * made       count results, overwritten; may be null
 * scratch    made for this generator
 * returns    NLG_OK; NLG_OUT_OF_MEMORY, after which theta and made are undefined; or NLG_INVALID_ARGUMENT. If count is 0, phi,
 *            validity and theta may be null */
nlg_status nlg_make_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          size_t count, float* theta, nlg_made* made, nlg_scratch* scratch);

/* A loaded light grid: probes, their weighting functions and their light. */
typedef struct nlg_light_grid nlg_light_grid;

/* Loads a light grid of nlg-bake, from a path or from bytes that are needed only during the call. Every byte is verified.
 *
 * path     as "level.safetensors"; UTF-8 on Windows
 * grid     receives the handle; null on failure
 * detail   as of nlg_generator_load */
nlg_status nlg_light_grid_load(const char* path, nlg_light_grid** grid, char* detail, size_t detail_size);
nlg_status nlg_light_grid_load_bytes(const void* bytes, size_t byte_count, nlg_light_grid** grid, char* detail,
                                     size_t detail_size);
void nlg_light_grid_free(nlg_light_grid* grid);

size_t nlg_light_grid_probe_count(const nlg_light_grid* grid);
/* Where the probes stand.
 *
 * positions_m   probe_count x 3 doubles, overwritten: world coordinates, metres */
void nlg_light_grid_probe_positions(const nlg_light_grid* grid, double* positions_m);
/* Returns 1 if the grid has light, else 0: all its positions are then unlit. */
int nlg_light_grid_has_light(const nlg_light_grid* grid);

/* The box in which light can be looked up, of all cells in use: low and high corner, 3 doubles each, overwritten, world coordinates,
 * metres. low_m > high_m if there are none. */
void nlg_light_grid_bounds(const nlg_light_grid* grid, double* low_m, double* high_m);
/* Radiance as a mean over all directions and all probes that have weight, for an exposure: .5 over it shows white paint at half
 * brightness. After nlg_light_grid_mix, of the mixture.
 *
 * rgb   3 floats, overwritten; 0 without light */
void nlg_light_grid_mean_radiance(const nlg_light_grid* grid, float* rgb);

/* Returns the number of groups of light, in a fixed order. 0: the grid was baked without --light-groups and --light-state. */
size_t nlg_light_grid_group_count(const nlg_light_grid* grid);
/* Returns a group's name, valid as long as the grid; null if there is no such group. */
const char* nlg_light_grid_group_name(const nlg_light_grid* grid, size_t group);
/* Dims, colours and switches groups: later look-ups see the sum of their light, each times its colour. Colours start as 1, those
 * of light states after the first as 0. Costs about 30 multiply-adds per probe and group. No other thread may look up in this grid
 * during the call.
 *
 * colours   3 floats per group, red, green and blue: linear factors, finite, as 1, 0.5, 0.5; may be null if there are no groups
 * returns   NLG_OK; NLG_OUT_OF_MEMORY; or NLG_INVALID_ARGUMENT if light would exceed 2^30, and nothing has changed */
nlg_status nlg_light_grid_mix(nlg_light_grid* grid, const float* colours);

/* How a position is lit (look_up.h). Values never change. */
typedef enum nlg_light_status NLG_OF_INT {
  NLG_LIT = 0,    /* lit by weighting functions */
  NLG_FAINT = 1,  /* weights cannot be trusted fully; the darkest probes around give the rest */
  NLG_UNLIT = 2,  /* no probe around has a function, or the grid has no light; the result is 0 */
  NLG_OUTSIDE = 3 /* in no cell, or not finite; the result is the light of the nearest used cell within one unit, or 0 */
} nlg_light_status;

/* Looks up irradiance on a plane at a position. Allocates nothing and cannot fail.
 *
 * position_m   3 doubles, world coordinates of the bake, metres; if one is not finite, the position is outside
 * normal       3 floats, length 1, as 0, 1, 0; one that is not finite or far longer than 1 gives 0 and NLG_UNLIT
 * rgb          3 floats, overwritten: each at least a tenth of its mean over all normals, and 0 */
nlg_light_status nlg_irradiance(const nlg_light_grid* grid, const double* position_m, const float* normal, float* rgb);

/* Working memory of nlg_irradiances, 1.2 MB: for any grid. Each thread needs its own. */
typedef struct nlg_look_up_scratch nlg_look_up_scratch;

/* scratch   receives the handle; null on failure
 * returns   NLG_OK; NLG_OUT_OF_MEMORY; or NLG_SIMD_UNAVAILABLE */
nlg_status nlg_look_up_scratch_create(nlg_look_up_scratch** scratch);
void nlg_look_up_scratch_free(nlg_look_up_scratch* scratch);

/* nlg_irradiance for many positions, on vectors: 3 to 8 times as fast, fastest if neighbours in the list are near each other.
 * Results differ from nlg_irradiance by rounding.
 *
 * positions_m   count x 3 doubles
 * normals       count x 3 floats
 * rgb           count x 3 floats, overwritten
 * status        count bytes, nlg_light_status each, overwritten */
void nlg_irradiances(const nlg_light_grid* grid, const double* positions_m, const float* normals, size_t count, float* rgb,
                     uint8_t* status, nlg_look_up_scratch* scratch);

/* In C, passing positions as floats would only warn, and they would be read as doubles: here it is an error. */
#if !defined(__cplusplus) && defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
#define NLG_DOUBLES(positions) _Generic((positions), double* : (positions), const double* : (positions))
#define nlg_irradiance(grid, position_m, normal, rgb) nlg_irradiance(grid, NLG_DOUBLES(position_m), normal, rgb)
#define nlg_irradiances(grid, positions_m, normals, count, rgb, status, scratch) \
  nlg_irradiances(grid, NLG_DOUBLES(positions_m), normals, count, rgb, status, scratch)
#endif

#ifdef __cplusplus
}
#endif

#endif /* NLG_C_API_NLG_H_ */
