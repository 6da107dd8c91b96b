/* The library for engines in other languages. At bake time: weights in, theta out, and what theta stands for at any point. In the
 * game: a light grid in, irradiance at any position out.
 *
 * C11. No exception leaves these functions and none of them keeps state, but for the support pattern, which the first of them
 * that needs it makes once (safe from any thread). Words and formats are those of docs/reference/formats.md.
 *
 * Threads   A generator and a light grid are only read once they are loaded: any number of threads may share them. A scratch
 *           serves one thread at a time.
 * Memory    nlg_generate, nlg_evaluate, nlg_check_theta and both look-ups allocate nothing and cannot fail: all they need
 *           comes with the generator or grid and the scratch. nlg_make_theta allocates. Every handle is freed by its own
 *           function; a null handle may be freed.
 * Pointers  Never null, except where it is said. Arrays have no alignment to keep. Every function looks: what returns a status answers a
 *           null pointer with NLG_INVALID_ARGUMENT, what returns a count, a text or a pointer with 0 or null, nlg_check_theta with NaN and
 *           a 0 for passes, nlg_irradiance with NLG_OUTSIDE; the others then write nothing.
 */
#ifndef NLG_C_API_NLG_H_
#define NLG_C_API_NLG_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define NLG_SUPPORT_POINT_COUNT 8192 /* P */

/* An enumeration in C may hold any int; in C++ it only may if it says so, and everything else is undefined. */
#ifdef __cplusplus
#define NLG_OF_INT : int
#else
#define NLG_OF_INT
#endif

/* Why a file was refused, and what else may go wrong. Values stay what they are; later versions add to them. */
typedef enum nlg_status NLG_OF_INT {
  NLG_OK = 0,
  NLG_CANNOT_OPEN = 1,       /* the system refused, or it is no regular file */
  NLG_CANNOT_READ = 2,       /* the system refused, or the file is larger than 1 GiB */
  NLG_TOO_SHORT = 3,         /* no header length, or fewer bytes than the tensors need */
  NLG_HEADER_TOO_LARGE = 4,  /* header above 1 MiB or past the end of the file */
  NLG_HEADER_MALFORMED = 5,  /* no safetensors header */
  NLG_TENSOR_MALFORMED = 6,  /* another dtype, shape and bytes disagree, overlap, hole, misaligned, bytes behind the last one */
  NLG_TENSOR_MISSING = 7,    /* a tensor or metadata key that a generator needs is not there */
  NLG_TENSOR_UNEXPECTED = 8, /* a tensor of another shape than the generator's */
  NLG_VALUE_NOT_FINITE = 9,
  NLG_VALUE_OUT_OF_RANGE = 10,
  NLG_VERSION_UNKNOWN = 11,
  NLG_PATTERN_UNKNOWN = 12,  /* made for another support pattern */
  NLG_SIMD_UNAVAILABLE = 13, /* the environment variable NLG_SIMD names a target that this build or machine does not have */
  NLG_DIGEST_MISMATCH = 14,  /* the file's bytes are not those that its SHA-256 is of: damaged */
  NLG_OUT_OF_MEMORY = 100,
  NLG_INVALID_ARGUMENT = 101 /* a null pointer, a scratch of another generator */
} nlg_status;

/* A short English name for messages: "tensor_missing"; "unknown" for a value that is none. Lives for ever. */
const char* nlg_status_name(nlg_status status);

/* A loaded weights file, ready to run. */
typedef struct nlg_generator nlg_generator;

/* Working memory of one thread for one generator. */
typedef struct nlg_scratch nlg_scratch;

/* Loads a weights file, from a path or from bytes that are needed only during the call.
 *
 * path          in UTF-8 on Windows
 * bytes         may be null when byte_count is 0
 * generator     receives the handle; null on failure
 * detail        receives one line of UTF-8, cut to fit and ended by a zero: on failure where and why, on success an empty
 *               text. May be null when detail_size is 0 */
nlg_status nlg_generator_load(const char* path, nlg_generator** generator, char* detail, size_t detail_size);
nlg_status nlg_generator_load_bytes(const void* bytes, size_t byte_count, nlg_generator** generator, char* detail,
                                    size_t detail_size);
void nlg_generator_free(nlg_generator* generator);

/* "mlp", "tent_mlp", "pf5", …: what theta stands for (docs/reference/formats.md). Lives for ever. */
const char* nlg_representation_name(const nlg_generator* generator);
/* Networks: the slope of their LeakyReLU, in (0, 1), which a look-up in the game needs. */
float nlg_representation_slope(const nlg_generator* generator);
/* D: how many floats one theta has. */
size_t nlg_theta_count(const nlg_generator* generator);
/* D floats, as long as the generator lives: the theta that the training started from. */
const float* nlg_theta0(const nlg_generator* generator);

/* The points at which an engine samples its functions.
 *
 * points_xyz    receives P x 3 floats in local coordinates, (-1, 1), one unit being one probe spacing; they live for ever
 * pattern_hash  receives what every file that was made for these points carries
 * returns       NLG_OK or NLG_OUT_OF_MEMORY; cannot fail any more once a generator has been loaded */
nlg_status nlg_support_pattern(const float** points_xyz, uint64_t* pattern_hash);

/* What stored theta are rounded to: nlg_make_theta hands out the floats that a light grid of this precision holds. */
typedef enum nlg_theta_precision NLG_OF_INT {
  NLG_THETA_FLOAT32 = 0,
  NLG_THETA_FLOAT16 = 1,
  NLG_THETA_INT8 = 2
} nlg_theta_precision;

/* The policy from a function to the theta that is stored: policy.h says what its stages do, and
 * policy_options.def says what each option is, its default and its range; none may be a NaN. A scratch has one generator,
 * so that there are no options of the choice among several. */
typedef struct nlg_policy_options {
#define NLG_CHOICE_OPTION(type, name, value, low, high, help)
#define NLG_POLICY_OPTION(type, name, value, low, high, help) type name;
#include "policy_options.def"          /* beside this header, by whatever path that is included */
  nlg_theta_precision theta_precision; /* NLG_THETA_INT8 */
} nlg_policy_options;

/* The defaults: those of nlg-bake. */
nlg_policy_options nlg_default_policy(void);

/* The name of the first option that is not where it must lie, "refine_first_steps"; null when all of them are. Lives for ever. */
const char* nlg_policy_out_of_range(const nlg_policy_options* options);

/* options   what nlg_make_theta and nlg_check_theta of this scratch do; null: the defaults
 * scratch   receives the handle; null on failure. The generator must outlive it
 * returns   NLG_OK; NLG_OUT_OF_MEMORY; or NLG_VALUE_OUT_OF_RANGE, of an option that nlg_policy_out_of_range names */
nlg_status nlg_scratch_create(const nlg_generator* generator, const nlg_policy_options* options, nlg_scratch** scratch);
void nlg_scratch_free(nlg_scratch* scratch);

/* theta of any number of functions. Every function has the same theta whatever stands beside it in the call.
 *
 * phi     count x P bytes, round(255 phi) at the support points in their order; 0 at points inside solid
 * theta   count x D floats, overwritten
 * scratch of this generator */
void nlg_generate(const nlg_generator* generator, const uint8_t* phi, size_t count, float* theta, nlg_scratch* scratch);

/* What one theta stands for at any points.
 *
 * theta    D floats, all finite
 * x, y, z  count floats each, local coordinates, all finite; outside (-1, 1) the values mean nothing
 * values   count floats, overwritten; not clamped
 * scratch  of this generator */
void nlg_evaluate(const nlg_generator* generator, const float* theta, size_t count, const float* x, const float* y,
                  const float* z, float* values, nlg_scratch* scratch);

/* One theta against its function, over all valid support points. */
typedef struct nlg_check {
  double rmse;       /* not finite when theta is not */
  double blend_rmse; /* the root of the loss, likewise: what fits minimise */
  double leak_mean;  /* mean |value| over valid points whose phi is 0 */
  double leak_share; /* share of them that leak */
  int passes;        /* 1 or 0 */
} nlg_check;

/* Checks a theta of this generator's representation. Allocates nothing, cannot fail.
 *
 * phi        P bytes; validity P / 8 bytes, bit i of byte b is point 8 b + i: 1 outside solid
 * blend_sum  P bytes, or null: as of nlg_make_theta
 * theta      D floats
 * scratch    of this generator, made with the options of the check */
nlg_check nlg_check_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          const float* theta, nlg_scratch* scratch);

/* What became of one function. */
typedef struct nlg_made {
  int has_theta;       /* 0: the bare tent is enough, and theta is all zeros */
  int took_fit;        /* 1: it took a step of Adam or Levenberg-Marquardt */
  const char* ended;   /* the stage that made theta what it is: "network", "last_layer", "refinement", ...; lives for ever */
  nlg_check network;   /* of one pass of the network */
  nlg_check corrected; /* after the exact last layer */
  nlg_check fitted;    /* after every fit, the refinement included */
  nlg_check stored;    /* after rounding: of the theta that is handed out */
  double elapsed_us;   /* of this function, by a steady clock */
} nlg_made;

/* The whole policy: bare tent, network, check, exact last layer, short fits, refinement of what fails, rounding. Takes tens of microseconds for most
 * functions and milliseconds for the hardest; docs/reference/results.md has the times. Every function has the same theta whatever
 * stands beside it in the call.
 *
 * phi        count x P bytes, round(255 phi) at the support points in their order; 0 at points inside solid
 * validity   count x P / 8 bytes, bit i of byte b is point 8 b + i: 1 outside solid
 * blend_sum  count x P bytes, round(255 min(1, S)): S is the sum, over all probes of the grid's cell around the point, of their functions
 *            there. A fit keeps what little a probe has where few others see the point (docs/theory/math.md §5). Null: S is
 *            taken as 1, as if other probes saw whatever this one sees, and places that it alone sees may turn black
 * theta      count x D floats, overwritten
 * made       count of them, overwritten; may be null
 * scratch    of this generator
 * returns   NLG_OK; NLG_OUT_OF_MEMORY, after which theta and made hold nothing of use; or NLG_INVALID_ARGUMENT. When count is 0, phi,
 *           validity and theta may be null */
nlg_status nlg_make_theta(const nlg_generator* generator, const uint8_t* phi, const uint8_t* validity, const uint8_t* blend_sum,
                          size_t count, float* theta, nlg_made* made, nlg_scratch* scratch);

/* A loaded light grid: probes, their weighting functions and their light. */
typedef struct nlg_light_grid nlg_light_grid;

/* Loads what nlg-bake wrote, from a path or from bytes that are needed only during the call. Every byte is checked.
 *
 * grid     receives the handle; null on failure
 * detail   as of nlg_generator_load */
nlg_status nlg_light_grid_load(const char* path, nlg_light_grid** grid, char* detail, size_t detail_size);
nlg_status nlg_light_grid_load_bytes(const void* bytes, size_t byte_count, nlg_light_grid** grid, char* detail,
                                     size_t detail_size);
void nlg_light_grid_free(nlg_light_grid* grid);

size_t nlg_light_grid_probe_count(const nlg_light_grid* grid);
/* 1 or 0; a grid without light is unlit everywhere. */
int nlg_light_grid_has_light(const nlg_light_grid* grid);

/* Groups of light, of a grid that nlg-bake --light-groups or --light-set made: 0 where all light is one. Their order does not change. */
size_t nlg_light_grid_group_count(const nlg_light_grid* grid);
/* A group's name, as long as the grid lives; null where there is no such group. */
const char* nlg_light_grid_group_name(const nlg_light_grid* grid, size_t group);
/* Dims, colours and switches groups: look-ups that follow see the sum of their light, each times its colour. All are 1 to begin
 * with, but for light sets after the first, which are 0. About 30 multiply-adds a probe and group. No other thread may look up in this
 * grid meanwhile.
 *
 * colours   3 floats a group, red, green and blue, linear, finite; may be null where there are no groups
 * returns   NLG_OK; NLG_OUT_OF_MEMORY; or NLG_INVALID_ARGUMENT where light would be beyond 2^30, and it stays as it was */
nlg_status nlg_light_grid_mix(nlg_light_grid* grid, const float* colours);

/* Where light at a position comes from: look_up.h has the words. Values stay what they are. */
typedef enum nlg_light_status NLG_OF_INT {
  NLG_LIT = 0,    /* by weighting functions */
  NLG_FAINT = 1,  /* no weight can be believed wholly: the darkest probes around give what is missing */
  NLG_UNLIT = 2,  /* no probe around has a function, or the grid no light: 0 */
  NLG_OUTSIDE = 3 /* in no cell, or not finite: light of the nearest used cell within one unit, 0 where there is none */
} nlg_light_status;

/* Irradiance on a plane at a position.
 *
 * position_m   3 doubles, world coordinates of the bake, metres; one that is not finite is outside
 * normal       3 floats, length 1; one that is no direction gives 0 and NLG_UNLIT
 * rgb          3 floats, overwritten, none below 0 */
nlg_light_status nlg_irradiance(const nlg_light_grid* grid, const double* position_m, const float* normal, float* rgb);

/* Working memory of nlg_irradiances, 1.2 MB: for any grid, for one thread at a time. */
typedef struct nlg_look_up_scratch nlg_look_up_scratch;

/* returns   NLG_OK; NLG_OUT_OF_MEMORY, *scratch null; or NLG_SIMD_UNAVAILABLE as of nlg_generator_load, *scratch null */
nlg_status nlg_look_up_scratch_create(nlg_look_up_scratch** scratch);
void nlg_look_up_scratch_free(nlg_look_up_scratch* scratch);

/* The same of many positions, on vectors: several times faster, the more so the more neighbours in the list stand near each other.
 * Differs from nlg_irradiance by rounding.
 *
 * positions_m   count x 3 doubles
 * normals       count x 3 floats
 * rgb           count x 3 floats, overwritten
 * status        count bytes, nlg_light_status each, overwritten */
void nlg_irradiances(const nlg_light_grid* grid, const double* positions_m, const float* normals, size_t count, float* rgb,
                     uint8_t* status, nlg_look_up_scratch* scratch);

/* Positions of floats would compile in C with no more than a warning, and be read as doubles: here they are an error. */
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
