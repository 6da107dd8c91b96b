/* Light at a position, out of grid.bin as `nlg-export shader` writes it: C99, no library but the C library's
   mathematics. Layout: shader_grid.h of neural-light-grid; what is computed is what its look_up.glsl computes.

       NlgGrid grid = {bytes, size};                             bytes of grid.bin, which the caller keeps
       if (!nlgIsWhole(&grid)) ...                               once: its bytes against the digest that it holds
       float rgb[3];
       NlgGridStatus status = nlgIrradiance(&grid, position_m, normal, rgb);

   Irradiance on a plane that faces the normal (length 1), in the level's metres: a diffuse surface multiplies it by its albedo
   over pi. In no cell, the nearest cell within a unit lends its light. Takes no memory, cannot fail: no byte outside of the grid is
   read whatever the bytes, position and normal are. Any number of threads may look up in one grid. */
#ifndef NLG_LIGHT_GRID_H
#define NLG_LIGHT_GRID_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
  const uint8_t* bytes;
  size_t size;
} NlgGrid;

/* The numbers are those of nlg_light_status in nlg.h; one program may include both headers. */
typedef enum { NLG_GRID_LIT, NLG_GRID_FAINT, NLG_GRID_UNLIT, NLG_GRID_OUTSIDE } NlgGridStatus;

enum {
  NLG_KIND_NONE,
  NLG_KIND_TENT,
  NLG_KIND_NETWORK_4,
  NLG_KIND_NETWORK_44,
  NLG_KIND_NETWORK_88,
  NLG_KIND_FIELD,
  NLG_KIND_BRICK
};
/* of a probe's tent: what a fit may leave behind walls */
#define NLG_RESIDUE 0.05f
/* of the light around a place: added to a probe's own where those with the least count most */
#define NLG_DARKEST_FLOOR 0.01f
/* of a channel's mean irradiance over all normals: no normal has less, or walls beside a bright source have coloured stains */
#define NLG_IRRADIANCE_FLOOR 0.1f
enum { NLG_FLAG_TENT = 8, NLG_FLAG_SIGMOID = 16, NLG_FLAG_HALVES = 32 };

typedef struct {
  uint32_t slot, edge, side_log2; /* word of its low corner's slot; slots along an edge of its brick; its side in units */
  float from_low[3];              /* where the position lies, in shares of the side */
} NlgCell;

/* A probe around the position. */
typedef struct {
  uint32_t record, theta, kind,
      resolution; /* words of its light and theta; kind and flags; nodes along an edge of a field or brick */
  float slope, step, local[3], tent, ratio;
} NlgCorner;

/* Every read is here: 0 beyond the grid's end. */
static inline uint32_t nlgWord(const NlgGrid* grid, uint32_t i) {
  const uint8_t* b;
  if (i >= grid->size / 4) return 0;
  b = grid->bytes + (size_t)i * 4;
  return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}
static inline float nlgFloatOf(uint32_t bits) {
  union {
    uint32_t bits;
    float value;
  } of;
  of.bits = bits;
  return of.value;
}
static inline float nlgFloat(const NlgGrid* grid, uint32_t i) { return nlgFloatOf(nlgWord(grid, i)); }
/* Number i of those that begin at a word: float16, or signed bytes. */
static inline float nlgHalf(const NlgGrid* grid, uint32_t word, uint32_t i) {
  const uint32_t h = nlgWord(grid, word + i / 2) >> 16 * (i % 2);
  const float magnitude =
      nlgFloatOf((h & 0x7fff) << 13) * 5.19229686e33f; /* 2^112: from the exponent of one to that of the other */
  return (h & 0x8000) != 0 ? -magnitude : magnitude;
}
static inline float nlgByte(const NlgGrid* grid, uint32_t word, uint32_t i) {
  const int byte = (int)(nlgWord(grid, word + i / 4) >> 8 * (i % 4) & 0xff);
  return (float)(byte < 128 ? byte : byte - 256);
}
/* axes of light, bits of a record's scale, words of a record */
static inline uint32_t nlgLightAxes(const NlgGrid* grid) { return nlgWord(grid, 16) < 27 ? nlgWord(grid, 16) : 27; }
static inline uint32_t nlgScaleBits(const NlgGrid* grid) { return nlgWord(grid, 17) & 31; }
static inline uint32_t nlgLightWords(const NlgGrid* grid) { return nlgWord(grid, 18); }
static inline uint32_t nlgLightFours(const NlgGrid* grid) { return (nlgLightWords(grid) + 3) / 4 * 4; }
/* records of light that a probe has: 1, or one of each group */
static inline uint32_t nlgLightGroups(const NlgGrid* grid) {
  const uint32_t groups = nlgWord(grid, 19) < 16 ? nlgWord(grid, 19) : 16;
  return groups > 0 ? groups : 1;
}
/* Of three numbers: not of NaN, and other than <= it raises nothing, which an engine may trap. */
static inline int nlgIsWithin(const float* three, float most) {
  return islessequal(fabsf(three[0]), most) && islessequal(fabsf(three[1]), most) && islessequal(fabsf(three[2]), most);
}
static inline float nlgBetween(float value, float low, float high) { return value < low ? low : value > high ? high : value; }
/* Below -87 it stays what it is there: no exponential overflows. */
static inline float nlgLogistic(float logit) { return 1.0f / (1.0f + expf(logit < -87.0f ? 87.0f : -logit)); }

/* unit: of the lattice, >= 0; units: the position, in the closed cube of that unit. 0: in no used cell. */
static inline int nlgCellOfUnit(const NlgGrid* grid, const int32_t* unit, const float* units, NlgCell* cell) {
  uint32_t entry, cells, block = 0, at = 0;
  int axis;
  for (axis = 2; axis >= 0; --axis) {
    const int64_t place = (int64_t)(unit[axis] >> 2) - (int32_t)nlgWord(grid, 4 + (uint32_t)axis);
    const uint32_t count = nlgWord(grid, 8 + (uint32_t)axis);
    if (place < 0 || place >= (int64_t)count) return 0;
    block = block * count + (uint32_t)place;
  }
  entry = nlgWord(grid, nlgWord(grid, 7) + block);
  if (entry == 0xffffffffu) return 0;
  cells = 1u << (entry >> 27 & 3);
  cell->side_log2 = entry >> 29;
  cell->edge = cells + 1;
  for (axis = 2; axis >= 0; --axis) {
    const int32_t side = (int32_t)1 << cell->side_log2;
    at = at * cell->edge + ((uint32_t)unit[axis] >> cell->side_log2 & (cells - 1));
    cell->from_low[axis] = (units[axis] - (float)(unit[axis] & -side)) / (float)side;
  }
  cell->slot = nlgWord(grid, 11) + (entry & 0x7ffffff) + at;
  return nlgWord(grid, cell->slot) >> 31 != 0;
}

static inline int nlgFindCell(const NlgGrid* grid, const float* units, NlgCell* cell) {
  int32_t unit[3];
  int axis;
  for (axis = 0; axis < 3; ++axis) {
    if (!(units[axis] >= 0.0f && units[axis] < 2097152.0f)) return 0; /* so is what is no number */
    unit[axis] = (int32_t)units[axis];
  }
  return nlgCellOfUnit(grid, unit, units, cell);
}

/* A used cell holds whole units: the nearest of the 26 around is as near as the nearest cell. */
static inline int nlgFindNearCell(const NlgGrid* grid, const float* units, NlgCell* nearest) {
  float least = 3.0e38f;
  int axis, n, found = 0;
  for (axis = 0; axis < 3; ++axis) {
    if (!(units[axis] > -1.0f && units[axis] < 2097152.0f)) return 0;
  }
  for (n = 0; n < 27; ++n) {
    const int32_t step[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    int32_t unit[3];
    float place[3], square = 0.0f;
    NlgCell cell;
    for (axis = 0; axis < 3; ++axis) {
      unit[axis] = (int32_t)floorf(units[axis]) + step[axis];
      place[axis] = nlgBetween(units[axis], (float)unit[axis], (float)unit[axis] + 1.0f);
      square += (units[axis] - place[axis]) * (units[axis] - place[axis]);
    }
    if (unit[0] < 0 || unit[1] < 0 || unit[2] < 0 || square >= least || !nlgCellOfUnit(grid, unit, place, &cell)) continue;
    least = square;
    *nearest = cell;
    found = 1;
  }
  return found;
}

static inline NlgCorner nlgCornerOf(const NlgGrid* grid, const NlgCell* cell, uint32_t c) {
  const uint32_t high[3] = {c & 1, c >> 1 & 1, c >> 2}, class_count = nlgWord(grid, 13);
  const uint32_t slot = nlgWord(grid, cell->slot + (high[2] * cell->edge + high[1]) * cell->edge + high[0]);
  const uint32_t probe = slot & 0x7ffffff;
  /* in shares of the probe's own spacing, which may be that of a larger cell */
  const float per_spacing = ldexpf(1.0f, (int)cell->side_log2 - (int)(slot >> 27 & 7));
  NlgCorner corner;
  uint32_t head = 20, next;
  int axis;
  corner.tent = corner.ratio = 1.0f;
  for (axis = 0; axis < 3; ++axis) {
    const float apart = high[axis] ? 1.0f - cell->from_low[axis] : cell->from_low[axis], local = apart * per_spacing;
    corner.local[axis] = high[axis] ? -local : local;
    corner.tent *= 1.0f - local;
    if (per_spacing < 1.0f) corner.ratio *= (1.0f - apart) / (1.0f - local);
  }
  /* probes are numbered class by class */
  for (next = 1; next < class_count && next < 258; ++next) {
    if (probe >= nlgWord(grid, 20 + 8 * next)) head = 20 + 8 * next;
  }
  corner.record = 4 * (nlgWord(grid, head + 1) + (probe - nlgWord(grid, head)) * nlgWord(grid, head + 2));
  corner.kind = nlgWord(grid, head + 3);
  corner.theta = corner.record + (nlgLightGroups(grid) - 1) * nlgLightFours(grid) +
                 ((corner.kind & 7) == NLG_KIND_BRICK ? nlgLightWords(grid) : nlgLightFours(grid));
  corner.slope = nlgFloat(grid, head + 4);
  corner.step = nlgFloat(grid, head + 6);
  corner.resolution = nlgWord(grid, head + 7);
  return corner;
}

/* 3 -> first -> second -> 1, without a second layer where second is 0. */
static inline float nlgNetwork(const NlgGrid* grid, const NlgCorner* of, uint32_t first, uint32_t second) {
  const int halves = (of->kind & NLG_FLAG_HALVES) != 0;
  const uint32_t theta = of->theta, hidden = 4 * first + (first + 1) * second, units = second > 0 ? second : first;
  const uint32_t last = theta + (halves ? hidden / 2 : hidden / 4);
  float inputs[8], outputs[8], sum;
  uint32_t input_count = 3, output_count = first, place = 0, layer, i, o;
  for (i = 0; i < 3; ++i) inputs[i] = of->local[i];
  for (layer = 0; layer < (second > 0 ? 2u : 1u); ++layer) {
    /* a column of the matrix after the other, then what is added */
    for (o = 0; o < output_count; ++o) outputs[o] = 0.0f;
    for (i = 0; i <= input_count; ++i) {
      for (o = 0; o < output_count; ++o, ++place) {
        const float number = halves ? nlgHalf(grid, theta, place) : of->step * nlgByte(grid, theta, place);
        outputs[o] += i < input_count ? inputs[i] * number : number;
      }
    }
    for (o = 0; o < output_count; ++o) inputs[o] = outputs[o] > 0.0f ? outputs[o] : of->slope * outputs[o];
    input_count = output_count;
    output_count = second;
  }
  sum = nlgHalf(grid, last, units);
  for (i = 0; i < units; ++i) sum += nlgHalf(grid, last, i) * inputs[i];
  return sum;
}

/* clamp(A, 0, 1) sigmoid(B), both trilinear in r^3 nodes; a node is a word: A, B. */
static inline float nlgField(const NlgGrid* grid, const NlgCorner* of) {
  const uint32_t r = of->resolution;
  uint32_t node[3], c;
  float share[3], a = 0.0f, b = 0.0f;
  int axis;
  if (r < 2 || r > 9) return 0.0f;
  for (axis = 0; axis < 3; ++axis) {
    const float at = nlgBetween((of->local[axis] + 1.0f) * 0.5f, 0.0f, 1.0f) * (float)(r - 1);
    node[axis] = (uint32_t)at < r - 2 ? (uint32_t)at : r - 2;
    share[axis] = at - (float)node[axis];
  }
  for (c = 0; c < 8; ++c) {
    const uint32_t x = c & 1, y = c >> 1 & 1, z = c >> 2, word = of->theta + ((node[2] + z) * r + node[1] + y) * r + node[0] + x;
    const float part = (x ? share[0] : 1.0f - share[0]) * (y ? share[1] : 1.0f - share[1]) * (z ? share[2] : 1.0f - share[2]);
    a += part * nlgHalf(grid, word, 0);
    b += part * nlgHalf(grid, word, 1);
  }
  return nlgBetween(a, 0.0f, 1.0f) * nlgLogistic(b);
}

/* sigmoid(L), L trilinear in r^3 nodes. A word holds the four nodes of a cell's low or high side along x, in steps. */
static inline float nlgBrick(const NlgGrid* grid, const NlgCorner* of) {
  const uint32_t r = of->resolution, name = nlgWord(grid, of->theta);
  uint32_t node[3], word, i;
  float share[3], along[4];
  int axis;
  if (r < 2 || r > 9) return 0.0f;
  for (axis = 0; axis < 3; ++axis) {
    const float at = nlgBetween((of->local[axis] + 1.0f) * 0.5f, 0.0f, 1.0f) * (float)(r - 1);
    node[axis] = (uint32_t)at < r - 2 ? (uint32_t)at : r - 2;
    share[axis] = at - (float)node[axis];
  }
  word = 4 * (name & 0x7ffffff) + (node[2] * (r - 1) + node[1]) * r + node[0];
  for (i = 0; i < 4; ++i) along[i] = nlgByte(grid, word, i) + share[0] * (nlgByte(grid, word + 1, i) - nlgByte(grid, word, i));
  for (i = 0; i < 4; i += 2) along[i] += share[1] * (along[i + 1] - along[i]);
  return nlgLogistic(ldexpf(along[0] + share[2] * (along[2] - along[0]), (int)(name >> 27) - 4));
}

/* What the weighting function gives of its tent, before the residue. */
static inline float nlgTentShare(const NlgGrid* grid, const NlgCorner* of) {
  const uint32_t kind = of->kind & 7;
  const float most = (of->kind & NLG_FLAG_TENT) != 0 ? 1.0f : of->tent;
  float phi = 0.0f;
  if (kind == NLG_KIND_TENT) return 1.0f;
  if (kind == NLG_KIND_BRICK) return nlgBrick(grid, of);
  if (kind == NLG_KIND_NETWORK_4) phi = nlgNetwork(grid, of, 4, 0);
  if (kind == NLG_KIND_NETWORK_44) phi = nlgNetwork(grid, of, 4, 4);
  if (kind == NLG_KIND_NETWORK_88) phi = nlgNetwork(grid, of, 8, 8);
  if (kind == NLG_KIND_FIELD) phi = nlgField(grid, of);
  if ((of->kind & NLG_FLAG_SIGMOID) != 0) phi = nlgLogistic(phi);
  return phi > 0.0f ? (phi < most ? phi / most : 1.0f) : 0.0f;
}

/* What a probe's light over the grid's scale is multiplied by: 0 where nothing is lit. record: its word */
static inline float nlgScale(const NlgGrid* grid, uint32_t record) {
  const uint32_t scale = nlgWord(grid, record) & ((1u << nlgScaleBits(grid)) - 1);
  return scale == 0 ? 0.0f : exp2f((float)scale / 16.0f);
}

/* How much a probe has of an axis of light, before its scale. axis: the word of its head */
static inline float nlgAlong(const NlgGrid* grid, uint32_t record, uint32_t axis) {
  const uint32_t field = nlgWord(grid, axis + 27);
  const uint32_t number = nlgWord(grid, record + (field & 7)) >> (field >> 3 & 31) & ((1u << (field >> 8 & 15)) - 1);
  const int offset = (int)(field >> 16 & 0xffff);
  return (float)number + (float)(offset < 32768 ? offset : offset - 65536);
}
static inline uint32_t nlgAxis(const NlgGrid* grid, uint32_t k) { return 20 + 8 * nlgWord(grid, 13) + 28 * k; }

/* What a group's light is multiplied by, of red, green or blue: three floats behind the axes of the head. */
static inline float nlgColour(const NlgGrid* grid, uint32_t group, uint32_t channel) {
  return nlgWord(grid, 19) == 0 ? 1.0f : nlgFloat(grid, nlgAxis(grid, nlgLightAxes(grid)) + 4 * group + channel);
}

/* Of a probe's light over all directions, over the grid's scale. record: its word */
static inline float nlgLuminance(const NlgGrid* grid, uint32_t record) {
  float all = 0.0f;
  uint32_t group, k;
  for (group = 0; group < nlgLightGroups(grid); ++group, record += nlgLightFours(grid)) {
    const float red = 0.2126f * nlgColour(grid, group, 0), green = 0.7152f * nlgColour(grid, group, 1),
                blue = 0.0722f * nlgColour(grid, group, 2);
    float luminance = 0.0f;
    for (k = 0; k < nlgLightAxes(grid); ++k) {
      const uint32_t axis = nlgAxis(grid, k);
      luminance += nlgAlong(grid, record, axis) *
                   (red * nlgFloat(grid, axis + 24) + green * nlgFloat(grid, axis + 25) + blue * nlgFloat(grid, axis + 26));
    }
    all += nlgScale(grid, record) * luminance;
  }
  return all > 0.0f ? all : 0.0f;
}

/* What the weights lack of 1 goes to tents, over the square of the light that their probes hold.
   tent    by corner, 0 of probes without a function; overwritten
   weight  by corner, they add up to the certainty; to 1 afterwards
   returns 0, with the weights as they were, where no probe around has a function */
static inline int nlgAddDarkest(const NlgGrid* grid, const uint32_t* record, float certainty, float* tent, float* weight) {
  float luminance[8], tents = 0.0f, light = 0.0f, mean, sum = 0.0f;
  int c;
  for (c = 0; c < 8; ++c) {
    luminance[c] = tent[c] > 0.0f ? nlgLuminance(grid, record[c]) : 0.0f;
    tents += tent[c];
    light += tent[c] * luminance[c];
  }
  if (!(tents > 0.0f)) return 0;
  mean = light / tents + 1e-20f;
  for (c = 0; c < 8; ++c) {
    const float darker = mean / (luminance[c] + NLG_DARKEST_FLOOR * mean);
    tent[c] *= darker * darker;
    sum += tent[c];
  }
  for (c = 0; c < 8; ++c) weight[c] += (1.0f - certainty) / sum * tent[c];
  return 1;
}

/* position_m, normal   three numbers each
   rgb                  three numbers, overwritten; 0 where the status is NLG_GRID_UNLIT, and where NLG_GRID_OUTSIDE has no cell near */
static inline NlgGridStatus nlgIrradiance(const NlgGrid* grid, const float* position_m, const float* normal, float* rgb) {
  static const float none[3] = {0.0f, 0.0f, 0.0f};
  const float* const n = nlgIsWithin(normal, 1.5f) ? normal : none;
  const float x = n[0], y = n[1], z = n[2];
  /* what irradiance takes of each coefficient */
  const float basis[9] = {0.88622693f,
                          1.02332671f * y,
                          1.02332671f * z,
                          1.02332671f * x,
                          0.85808553f * x * y,
                          0.85808553f * y * z,
                          0.24770796f * (3.0f * z * z - 1.0f),
                          0.85808553f * x * z,
                          0.42904276f * (x * x - y * y)};
  float units[3], tent[8], weight[8], sum = 0.0f, believed = 0.0f, certainty = 0.0f, mean[3] = {0.0f, 0.0f, 0.0f};
  uint32_t record[8], c, i, group;
  NlgGridStatus status = NLG_GRID_LIT;
  NlgCell cell = {0, 0, 0, {0.0f, 0.0f, 0.0f}};
  rgb[0] = rgb[1] = rgb[2] = 0.0f;
  if (n == none) return NLG_GRID_UNLIT; /* no direction */
  for (i = 0; i < 3; ++i) units[i] = position_m[i] - nlgFloat(grid, i);
  if (!nlgIsWithin(units, 1e7f)) return NLG_GRID_OUTSIDE; /* in metres: what follows overflows nothing, integers neither */
  for (i = 0; i < 3; ++i) units[i] *= nlgFloat(grid, 3);
  if (!nlgFindCell(grid, units, &cell)) {
    status = NLG_GRID_OUTSIDE;
    if (!nlgFindNearCell(grid, units, &cell)) return status;
  }
  for (c = 0; c < 8; ++c) {
    const NlgCorner corner = nlgCornerOf(grid, &cell, c);
    const float above = nlgTentShare(grid, &corner) - NLG_RESIDUE;
    record[c] = corner.record;
    /* at a place that is that of a probe without weight the tents of all others end: then all count alike */
    tent[c] = (corner.kind & 7) == NLG_KIND_NONE ? 0.0f : fmaxf(1e-20f, corner.tent * corner.ratio);
    weight[c] = above * corner.tent * corner.ratio;
    if (!(weight[c] >= 1e-6f * (1.0f - NLG_RESIDUE))) weight[c] = 0.0f;
    sum += weight[c];
    believed += weight[c] * above;
  }
  if (sum > 0.0f) {
    certainty = believed < NLG_RESIDUE * sum ? believed / (NLG_RESIDUE * sum) : 1.0f;
    for (c = 0; c < 8; ++c) weight[c] *= certainty / sum;
  }
  if (certainty < 1.0f) {
    const int has_function = nlgAddDarkest(grid, record, certainty, tent, weight);
    if (status == NLG_GRID_LIT) status = has_function ? NLG_GRID_FAINT : NLG_GRID_UNLIT;
    if (!has_function) return status;
  }
  for (group = 0; group < nlgLightGroups(grid); ++group) {
    const uint32_t beyond = group * nlgLightFours(grid);
    const float colour[3] = {nlgColour(grid, group, 0), nlgColour(grid, group, 1), nlgColour(grid, group, 2)};
    if (colour[0] == 0.0f && colour[1] == 0.0f && colour[2] == 0.0f) continue;
    for (i = 0; i < nlgLightAxes(grid); ++i) {
      const uint32_t axis = nlgAxis(grid, i);
      float along = 0.0f;
      for (c = 0; c < 8; ++c) {
        if (weight[c] != 0.0f) along += weight[c] * nlgScale(grid, record[c] + beyond) * nlgAlong(grid, record[c] + beyond, axis);
      }
      /* coefficients 1 to 8 of red, of green, of blue; then their coefficients 0, which are means over all normals */
      for (c = 0; c < 27; ++c) {
        const uint32_t channel = c < 24 ? c / 8 : c - 24;
        const float part = colour[channel] * along * basis[c < 24 ? c % 8 + 1 : 0] * nlgFloat(grid, axis + c);
        rgb[channel] += part;
        if (c >= 24) mean[channel] += part;
      }
    }
  }
  for (i = 0; i < 3; ++i) rgb[i] = nlgFloat(grid, 12) * fmaxf(0.0f, fmaxf(rgb[i], NLG_IRRADIANCE_FLOOR * mean[i]));
  return status;
}

/* 64 bytes more of a SHA-256 (FIPS 180-4). */
static inline void nlgDigestBlock(uint32_t* state, const uint8_t* block) {
  static const uint32_t round[64] = {
      0x428a2f98u, 0x71374491u, 0xb5c0fbcfu, 0xe9b5dba5u, 0x3956c25bu, 0x59f111f1u, 0x923f82a4u, 0xab1c5ed5u,
      0xd807aa98u, 0x12835b01u, 0x243185beu, 0x550c7dc3u, 0x72be5d74u, 0x80deb1feu, 0x9bdc06a7u, 0xc19bf174u,
      0xe49b69c1u, 0xefbe4786u, 0x0fc19dc6u, 0x240ca1ccu, 0x2de92c6fu, 0x4a7484aau, 0x5cb0a9dcu, 0x76f988dau,
      0x983e5152u, 0xa831c66du, 0xb00327c8u, 0xbf597fc7u, 0xc6e00bf3u, 0xd5a79147u, 0x06ca6351u, 0x14292967u,
      0x27b70a85u, 0x2e1b2138u, 0x4d2c6dfcu, 0x53380d13u, 0x650a7354u, 0x766a0abbu, 0x81c2c92eu, 0x92722c85u,
      0xa2bfe8a1u, 0xa81a664bu, 0xc24b8b70u, 0xc76c51a3u, 0xd192e819u, 0xd6990624u, 0xf40e3585u, 0x106aa070u,
      0x19a4c116u, 0x1e376c08u, 0x2748774cu, 0x34b0bcb5u, 0x391c0cb3u, 0x4ed8aa4au, 0x5b9cca4fu, 0x682e6ff3u,
      0x748f82eeu, 0x78a5636fu, 0x84c87814u, 0x8cc70208u, 0x90befffau, 0xa4506cebu, 0xbef9a3f7u, 0xc67178f2u};
  uint32_t w[64], s[8];
  int i;
#define NLG_ROTR(x, n) ((x) >> (n) | (x) << (32 - (n)))
  for (i = 0; i < 16; ++i)
    w[i] = (uint32_t)block[4 * i] << 24 | (uint32_t)block[4 * i + 1] << 16 | (uint32_t)block[4 * i + 2] << 8 |
           (uint32_t)block[4 * i + 3];
  for (i = 16; i < 64; ++i)
    w[i] = w[i - 16] + (NLG_ROTR(w[i - 15], 7) ^ NLG_ROTR(w[i - 15], 18) ^ w[i - 15] >> 3) + w[i - 7] +
           (NLG_ROTR(w[i - 2], 17) ^ NLG_ROTR(w[i - 2], 19) ^ w[i - 2] >> 10);
  for (i = 0; i < 8; ++i) s[i] = state[i];
  for (i = 0; i < 64; ++i) {
    const uint32_t a =
        s[7] + (NLG_ROTR(s[4], 6) ^ NLG_ROTR(s[4], 11) ^ NLG_ROTR(s[4], 25)) + ((s[4] & s[5]) ^ (~s[4] & s[6])) + round[i] + w[i];
    const uint32_t b =
        (NLG_ROTR(s[0], 2) ^ NLG_ROTR(s[0], 13) ^ NLG_ROTR(s[0], 22)) + ((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
    s[7] = s[6], s[6] = s[5], s[5] = s[4], s[4] = s[3] + a, s[3] = s[2], s[2] = s[1], s[1] = s[0], s[0] = a + b;
  }
#undef NLG_ROTR
  for (i = 0; i < 8; ++i) state[i] += s[i];
}

/* The first 8 bytes of the grid's SHA-256, these 8 taken as zeros, against those that stand in its head. 1: the grid is whole; 0: it
   is damaged, or older than its digest. Takes about 3 ms a megabyte: once, after loading. */
static inline int nlgIsWhole(const NlgGrid* grid) {
  enum { NLG_DIGEST_FIRST = 56, NLG_DIGEST_COUNT = 8 };
  uint32_t state[8] = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au, 0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};
  const size_t padded = (grid->size + 9 + 63) / 64 * 64;
  size_t at, i;
  if (grid->size < NLG_DIGEST_FIRST + NLG_DIGEST_COUNT) return 0;
  for (at = 0; at < padded; at += 64) {
    uint8_t block[64];
    for (i = 0; i < 64; ++i) {
      const size_t byte = at + i;
      if (byte < grid->size)
        block[i] = byte - NLG_DIGEST_FIRST < NLG_DIGEST_COUNT ? 0 : grid->bytes[byte];
      else if (padded - byte <= 8) /* how many bits there are, the largest byte first */
        block[i] = (uint8_t)((uint64_t)grid->size * 8 >> 8 * (padded - byte - 1));
      else
        block[i] = byte == grid->size ? 0x80 : 0;
    }
    nlgDigestBlock(state, block);
  }
  for (i = 0; i < NLG_DIGEST_COUNT; ++i)
    if (grid->bytes[NLG_DIGEST_FIRST + i] != (uint8_t)(state[i / 4] >> (24 - 8 * (i % 4)))) return 0;
  return 1;
}

#endif
