// Light at a position, out of a shader grid (shader_grid.h): what lookUpIrradiance says, for a pixel,
// whose normal has length 1: others are not refused here.
//
// GLSL 4.50 and GLSL ES 3.00; HLSL follows by spirv-cross. The tests compile it as C++ too. Whoever includes it gives the grid:
//
//     uvec4 nlgHeader(int i)    uvec4 number i of the grid's head: the same for all pixels, best kept as constants
//     uvec4 nlgFour(int i)      words 4 i … 4 i + 3 of the grid
//     uint nlgWord(int i)       word i of the grid
//
// and defines what the grid holds, as ShaderGrid::defines lists it: what is not there is not compiled. NLG_NEAR looks for the
// nearest cell where a position lies in none, as lookUpIrradiance does; without it such positions are dark.

#ifndef NLG_LIGHT_AXES  // for any grid
#define NLG_LIGHT_AXES int(nlgHeader(4).x)
#define NLG_LIGHT_WORDS int(nlgHeader(4).z)
#define NLG_LIGHT_GROUPS int(nlgHeader(4).w)
#endif
#ifdef NLG_LIGHT_GROUPS
#define NLG_GROUP_COUNT max(1, NLG_LIGHT_GROUPS)
#else
#define NLG_GROUP_COUNT 1
#endif
#define NLG_GROUP_FOURS ((NLG_LIGHT_WORDS + 3) / 4)             // uvec4 of a record of light
#define NLG_LIGHT_FOURS (NLG_GROUP_FOURS * NLG_GROUP_COUNT)  // of a probe's, before its theta

// Loops over the eight probes are to be unrolled, else what they hand on lies in memory: 2.6 times as slow for codes. Eight networks
// of two layers of 8 are too much code for that.
#if defined(GL_EXT_control_flow_attributes) && !defined(NLG_NETWORK_88)
#extension GL_EXT_control_flow_attributes : enable
#define NLG_UNROLL [[unroll]]
#else
#define NLG_UNROLL
#endif

const int NLG_LIT = 0, NLG_FAINT = 1, NLG_UNLIT = 2, NLG_OUTSIDE = 3;               // LightStatus
const int NLG_CLASSES = 5;                                                          // uvec4 of the head: the first class of probes
const int NLG_HEADS_A_CLASS = 2, NLG_HEADS_AN_AXIS = 7;                             // uvec4
const float NLG_LEAST_WEIGHT = 1e-6f, NLG_RESIDUE = 0.05f, NLG_DARKEST_FLOOR = 0.01f;  // kLeastWeight, kResidue, kDarkestFloor
const float NLG_IRRADIANCE_FLOOR = 0.1f;                                               // kIrradianceFloor (nlg/light_grid.h)

struct NlgLight {
  vec3 irradiance;
  int status;
};

// Radiance as spherical harmonics (nlg/light_grid.h): what a compute pass writes into textures.
struct NlgRadiance {
  vec3 sh[9];
  float certainty;  // ProbeWeights
  int status;
};

// What the probes around a position take of the blend.
struct NlgShares {
  int record[8];    // of a probe: uvec4 of its light
  float share[8];   // they add up to 1, or are all 0
  float certainty;  // ProbeWeights
  int status;
};

struct NlgCell {
  bool found;
  int slot;       // word of its low corner's slot
  int edge;       // slots along an edge of its brick
  int side_log2;  // units
  vec3 from_low;  // where the position lies, in shares of the side
};

// A probe around the position.
struct NlgCorner {
  int record;      // uvec4 of the probe's light; its theta follows
  int kind;        // of its class: NLG_KIND_… and flags
  float slope;     // of its LeakyReLU
  float step;      // of numbers in bytes
  int resolution;  // of its field or brick
  vec3 local;      // the position in its support, [-1, 1]
  float tent;      // of its support there
  float ratio;     // the cell's tent over that of the support
};

const int NLG_KIND_NONE = 0, NLG_KIND_TENT = 1, NLG_KIND_NETWORK_4 = 2, NLG_KIND_NETWORK_44 = 3, NLG_KIND_NETWORK_88 = 4,
          NLG_KIND_FIELD = 5, NLG_KIND_BRICK = 6;
const int NLG_FLAG_TENT = 8, NLG_FLAG_SIGMOID = 16, NLG_FLAG_HALVES = 32;  // beside the kind: its low three bits

vec4 nlgBytes(uint word) {
  return vec4(float(int(word << 24) >> 24), float(int(word << 16) >> 24), float(int(word << 8) >> 24), float(int(word) >> 24));
}
vec4 nlgHalves(uint low, uint high) { return vec4(unpackHalf2x16(low), unpackHalf2x16(high)); }
vec4 nlgLeaky(vec4 value, float slope) { return max(value, slope * value); }

// ---- from a position to its cell: two reads

// unit   of the lattice, >= 0; units: the position, in the closed cube of that unit
NlgCell nlgCellOfUnit(ivec3 unit, vec3 units) {
  NlgCell cell;
  cell.found = false;
  cell.slot = 0;
  cell.edge = 0;
  cell.side_log2 = 0;
  cell.from_low = vec3(0.0f);
  uvec4 low = nlgHeader(1), count = nlgHeader(2);
  ivec3 blocks = ivec3(int(count.x), int(count.y), int(count.z));
  ivec3 block = (unit >> 2) - ivec3(int(low.x), int(low.y), int(low.z));
  if (any(lessThan(block, ivec3(0))) || any(greaterThanEqual(block, blocks))) return cell;
  uint entry = nlgWord(int(low.w) + (block.z * blocks.y + block.y) * blocks.x + block.x);
  if (entry == 0xffffffffu) return cell;
  int cells = 1 << (int(entry >> 27) & 3);
  cell.side_log2 = int(entry >> 29);
  cell.edge = cells + 1;
  ivec3 at = (unit >> cell.side_log2) & (cells - 1);
  cell.slot = int(count.w) + int(entry & 0x7ffffffu) + (at.z * cell.edge + at.y) * cell.edge + at.x;
  int side = 1 << cell.side_log2;
  cell.from_low = (units - vec3(unit & -side)) / float(side);
  cell.found = nlgWord(cell.slot) >> 31 != 0u;
  return cell;
}

NlgCell nlgFindCell(vec3 units) {
  // what is no number is in no unit
  bool inside = all(greaterThanEqual(units, vec3(0.0f))) && all(lessThan(units, vec3(2097152.0f)));
  return nlgCellOfUnit(inside ? ivec3(floor(units)) : ivec3(-4), units);
}

#ifdef NLG_NEAR
// A used cell holds whole units: the nearest of the 26 around is as near as the nearest cell.
NlgCell nlgFindNearCell(vec3 units) {
  NlgCell nearest;
  nearest.found = false;
  if (!(all(greaterThan(units, vec3(-1.0f))) && all(lessThan(units, vec3(2097152.0f))))) return nearest;
  ivec3 unit = ivec3(floor(units));
  float least = 3.0e38f;
  for (int n = 0; n < 27; ++n) {
    ivec3 near = unit + ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    vec3 place = clamp(units, vec3(near), vec3(near) + vec3(1.0f));
    float distance_square = dot(units - place, units - place);
    if (any(lessThan(near, ivec3(0))) || distance_square >= least) continue;
    NlgCell cell = nlgCellOfUnit(near, place);
    if (!cell.found) continue;
    least = distance_square;
    nearest = cell;
  }
  return nearest;
}
#endif

NlgCorner nlgCornerOf(NlgCell cell, int c) {
  ivec3 high = ivec3(c & 1, c >> 1 & 1, c >> 2);
  uint slot = nlgWord(cell.slot + (high.z * cell.edge + high.y) * cell.edge + high.x);
  int probe = int(slot & 0x7ffffffu);
  // in shares of the probe's own spacing, which may be that of a larger cell
  float per_spacing = 1.0f / float(1 << (int(slot >> 27 & 7u) - cell.side_log2));
  vec3 is_high = vec3(high);
  vec3 apart = mix(cell.from_low, vec3(1.0f) - cell.from_low, is_high);
  vec3 local = apart * per_spacing;
  NlgCorner corner;
  corner.local = local * (vec3(1.0f) - 2.0f * is_high);
  vec3 tents = vec3(1.0f) - local;
  corner.tent = tents.x * tents.y * tents.z;
  corner.ratio = 1.0f;
  if (per_spacing < 1.0f) {
    vec3 ratios = (vec3(1.0f) - apart) / tents;
    corner.ratio = ratios.x * ratios.y * ratios.z;
  }
  // probes are numbered class by class
  int k = 0;
  for (int next = 1; next < NLG_CLASS_COUNT; ++next) {
    if (probe >= int(nlgHeader(NLG_CLASSES + 2 * next).x)) k = next;
  }
  uvec4 records = nlgHeader(NLG_CLASSES + 2 * k), numbers = nlgHeader(NLG_CLASSES + 2 * k + 1);
  corner.record = int(records.y) + (probe - int(records.x)) * int(records.z);
  corner.kind = int(records.w);
  corner.slope = uintBitsToFloat(numbers.x);
  corner.step = uintBitsToFloat(numbers.z);
  corner.resolution = int(numbers.w);
  return corner;
}

// ---- weighting functions

#ifdef NLG_HALVES
// Four numbers of theta in float16, by their place among all fours.
vec4 nlgHalfFour(NlgCorner of, int place) {
  uvec4 words = nlgFour(of.record + NLG_LIGHT_FOURS + (place >> 1));
  return (place & 1) == 0 ? nlgHalves(words.x, words.y) : nlgHalves(words.z, words.w);
}
bool nlgInHalves(NlgCorner of) { return (of.kind & NLG_FLAG_HALVES) != 0; }
#endif

#ifdef NLG_NETWORK_4
// 3 -> 4 -> 1
float nlgNetwork4(NlgCorner of) {
  vec4 x, y, z, bias, last;
  float last_bias;
#ifdef NLG_HALVES
  if (nlgInHalves(of)) {
    x = nlgHalfFour(of, 0), y = nlgHalfFour(of, 1), z = nlgHalfFour(of, 2), bias = nlgHalfFour(of, 3);
    last = nlgHalfFour(of, 4), last_bias = nlgHalfFour(of, 5).x;
  } else
#endif
  {
    int theta = of.record + NLG_LIGHT_FOURS;
    uvec4 a = nlgFour(theta), b = nlgFour(theta + 1);
    x = of.step * nlgBytes(a.x), y = of.step * nlgBytes(a.y), z = of.step * nlgBytes(a.z), bias = of.step * nlgBytes(a.w);
    last = nlgHalves(b.x, b.y), last_bias = unpackHalf2x16(b.z).x;
  }
  vec4 hidden = nlgLeaky(bias + x * of.local.x + y * of.local.y + z * of.local.z, of.slope);
  return last_bias + dot(last, hidden);
}
#endif

#ifdef NLG_NETWORK_44
// 3 -> 4 -> 4 -> 1
float nlgNetwork44(NlgCorner of) {
  vec4 x, y, z, bias, columns[4], second, last;
  float last_bias;
#ifdef NLG_HALVES
  if (nlgInHalves(of)) {
    x = nlgHalfFour(of, 0), y = nlgHalfFour(of, 1), z = nlgHalfFour(of, 2), bias = nlgHalfFour(of, 3);
    for (int i = 0; i < 4; ++i) columns[i] = nlgHalfFour(of, 4 + i);
    second = nlgHalfFour(of, 8), last = nlgHalfFour(of, 9), last_bias = nlgHalfFour(of, 10).x;
  } else
#endif
  {
    int theta = of.record + NLG_LIGHT_FOURS;
    uvec4 a = nlgFour(theta), b = nlgFour(theta + 1), c = nlgFour(theta + 2);
    x = of.step * nlgBytes(a.x), y = of.step * nlgBytes(a.y), z = of.step * nlgBytes(a.z), bias = of.step * nlgBytes(a.w);
    columns[0] = of.step * nlgBytes(b.x), columns[1] = of.step * nlgBytes(b.y);
    columns[2] = of.step * nlgBytes(b.z), columns[3] = of.step * nlgBytes(b.w);
    second = of.step * nlgBytes(c.x), last = nlgHalves(c.y, c.z), last_bias = unpackHalf2x16(c.w).x;
  }
  vec4 first = nlgLeaky(bias + x * of.local.x + y * of.local.y + z * of.local.z, of.slope);
  second += first.x * columns[0] + first.y * columns[1] + first.z * columns[2] + first.w * columns[3];
  return last_bias + dot(last, nlgLeaky(second, of.slope));
}
#endif

#ifdef NLG_NETWORK_88
// 3 -> 8 -> 8 -> 1
float nlgNetwork88(NlgCorner of) {
  vec4 x[2], y[2], z[2], bias[2], low, high, last_low, last_high;
  float last_bias;
  int theta = of.record + NLG_LIGHT_FOURS;
#ifdef NLG_HALVES
  bool halves = nlgInHalves(of);
  if (halves) {
    for (int n = 0; n < 2; ++n) {
      x[n] = nlgHalfFour(of, n), y[n] = nlgHalfFour(of, 2 + n), z[n] = nlgHalfFour(of, 4 + n), bias[n] = nlgHalfFour(of, 6 + n);
    }
    low = nlgHalfFour(of, 24), high = nlgHalfFour(of, 25);
    last_low = nlgHalfFour(of, 26), last_high = nlgHalfFour(of, 27), last_bias = nlgHalfFour(of, 28).x;
  } else
#endif
  {
    uvec4 a = nlgFour(theta), b = nlgFour(theta + 1), c = nlgFour(theta + 6), d = nlgFour(theta + 7);
    x[0] = of.step * nlgBytes(a.x), x[1] = of.step * nlgBytes(a.y), y[0] = of.step * nlgBytes(a.z), y[1] = of.step * nlgBytes(a.w);
    z[0] = of.step * nlgBytes(b.x), z[1] = of.step * nlgBytes(b.y);
    bias[0] = of.step * nlgBytes(b.z), bias[1] = of.step * nlgBytes(b.w);
    low = of.step * nlgBytes(c.x), high = of.step * nlgBytes(c.y);
    last_low = nlgHalves(c.z, c.w), last_high = nlgHalves(d.x, d.y), last_bias = unpackHalf2x16(d.z).x;
  }
  vec4 first[2];
  for (int n = 0; n < 2; ++n) {
    first[n] = nlgLeaky(bias[n] + x[n] * of.local.x + y[n] * of.local.y + z[n] * of.local.z, of.slope);
  }
  for (int pair = 0; pair < 4; ++pair) {
    vec4 four = first[pair >> 1];
    vec2 units = (pair & 1) == 0 ? vec2(four.x, four.y) : vec2(four.z, four.w);
#ifdef NLG_HALVES
    if (halves) {
      int place = 8 + 4 * pair;
      low += units.x * nlgHalfFour(of, place) + units.y * nlgHalfFour(of, place + 2);
      high += units.x * nlgHalfFour(of, place + 1) + units.y * nlgHalfFour(of, place + 3);
    } else
#endif
    {
      uvec4 columns = nlgFour(theta + 2 + pair);
      units *= of.step;
      low += units.x * nlgBytes(columns.x) + units.y * nlgBytes(columns.z);
      high += units.x * nlgBytes(columns.y) + units.y * nlgBytes(columns.w);
    }
  }
  return last_bias + dot(last_low, nlgLeaky(low, of.slope)) + dot(last_high, nlgLeaky(high, of.slope));
}
#endif

#ifdef NLG_FIELD
// clamp(A, 0, 1) sigmoid(B), both trilinear in r³ nodes; a node is a word: A, B.
float nlgField(NlgCorner of) {
  int r = of.resolution;
  vec3 position = clamp((of.local + vec3(1.0f)) * 0.5f, vec3(0.0f), vec3(1.0f)) * float(r - 1);
  ivec3 node = min(ivec3(position), ivec3(r - 2));
  vec3 share = position - vec3(node);
  vec2 sum = vec2(0.0f);
  for (int c = 0; c < 8; ++c) {
    ivec3 high = ivec3(c & 1, c >> 1 & 1, c >> 2);
    ivec3 corner = node + high;
    vec3 part = mix(vec3(1.0f) - share, share, vec3(high));
    int word = 4 * (of.record + NLG_LIGHT_FOURS) + (corner.z * r + corner.y) * r + corner.x;
    sum += part.x * part.y * part.z * unpackHalf2x16(nlgWord(word));
  }
  return clamp(sum.x, 0.0f, 1.0f) / (1.0f + exp(-sum.y));
}
#endif

#ifdef NLG_BRICK
// sigmoid(L), L trilinear in r³ nodes. A word holds the four nodes of a cell's low or high side along x, in steps.
float nlgBrick(NlgCorner of) {
  int r = of.resolution;
  float middle = 0.5f * float(r - 1);
  vec3 position = of.local * middle + vec3(middle);
  ivec3 node = min(ivec3(position), ivec3(r - 2));
  vec3 share = position - vec3(node);
  uint name = nlgWord(4 * (of.record + NLG_LIGHT_FOURS - NLG_GROUP_FOURS) + NLG_LIGHT_WORDS);
  int word = 4 * int(name & 0x7ffffffu) + (node.z * (r - 1) + node.y) * r + node.x;
  vec4 along_x = mix(nlgBytes(nlgWord(word)), nlgBytes(nlgWord(word + 1)), share.x);
  vec2 along_y = mix(vec2(along_x.x, along_x.z), vec2(along_x.y, along_x.w), share.y);
  float step = uintBitsToFloat(((name >> 27) + 123u) << 23);  // 2^e
  return 1.0f / (1.0f + exp(-step * mix(along_y.x, along_y.y, share.z)));
}
#endif

// What the weighting function gives of its tent, before the residue.
float nlgTentShare(NlgCorner corner) {
  int kind = corner.kind & 7;
  if (kind == NLG_KIND_NONE) return 0.0f;
  if (kind == NLG_KIND_TENT) return 1.0f;
#ifdef NLG_BRICK
  if (kind == NLG_KIND_BRICK) return nlgBrick(corner);
#endif
#if defined(NLG_NETWORK_4) || defined(NLG_NETWORK_44) || defined(NLG_NETWORK_88) || defined(NLG_FIELD)
  float phi = 0.0f;
#ifdef NLG_NETWORK_4
  if (kind == NLG_KIND_NETWORK_4) phi = nlgNetwork4(corner);
#endif
#ifdef NLG_NETWORK_44
  if (kind == NLG_KIND_NETWORK_44) phi = nlgNetwork44(corner);
#endif
#ifdef NLG_NETWORK_88
  if (kind == NLG_KIND_NETWORK_88) phi = nlgNetwork88(corner);
#endif
#ifdef NLG_FIELD
  if (kind == NLG_KIND_FIELD) phi = nlgField(corner);
#endif
  if ((corner.kind & NLG_FLAG_SIGMOID) != 0) phi = 1.0f / (1.0f + exp(-phi));
  float most = (corner.kind & NLG_FLAG_TENT) != 0 ? 1.0f : corner.tent;
  return phi > 0.0f ? (phi < most ? phi / most : 1.0f) : 0.0f;
#else
  return 0.0f;
#endif
}

// ---- light

// The shares of irradiance of the nine coefficients, for a normal of length 1 (nlg/light_grid.h).
struct NlgBasis {
  float mean;
  vec4 low, high;  // of orders 1 and 2
};
NlgBasis nlgBasisOf(vec3 n) {
  NlgBasis basis;
  basis.mean = 0.28209479f * 3.14159265f;
  basis.low = vec4(0.48860251f * 2.09439510f * vec3(n.y, n.z, n.x), 1.09254843f * 0.78539816f * n.x * n.y);
  basis.high = 0.78539816f * vec4(1.09254843f * n.y * n.z, 0.31539157f * (3.0f * n.z * n.z - 1.0f), 1.09254843f * n.x * n.z,
                                 0.54627422f * (n.x * n.x - n.y * n.y));
  return basis;
}

// What a probe holds of a group: a scale and a number for each axis of the level's light (packed_light.h).
struct NlgRecord {
  uint words[8];
  float scale;  // 0 where nothing is lit
};
NlgRecord nlgRecordOf(int record) {
  NlgRecord result;
  for (int four = 0; four < NLG_GROUP_FOURS; ++four) {
    uvec4 words = nlgFour(record + four);
    for (int i = 0; i < 4; ++i) result.words[4 * four + i] = words[i];
  }
  uint scale = result.words[0] & ((1u << nlgHeader(4).y) - 1u);
  result.scale = scale == 0u ? 0.0f : exp2(float(scale) / 16.0f);
  return result;
}
// The head of an axis: its coefficients, and where its number stands.
int nlgAxis(int k) { return NLG_CLASSES + NLG_HEADS_A_CLASS * NLG_CLASS_COUNT + NLG_HEADS_AN_AXIS * k; }
// What a group is multiplied by now: an engine writes it behind the axes of the head. Without groups all light is as it was baked.
vec3 nlgColour(int group) {
#ifdef NLG_LIGHT_GROUPS
  if (NLG_LIGHT_GROUPS == 0) return vec3(1.0f);
  vec4 colour = uintBitsToFloat(nlgHeader(nlgAxis(NLG_LIGHT_AXES) + group));
  return vec3(colour.x, colour.y, colour.z);
#else
  return vec3(1.0f);
#endif
}
#ifdef NLG_LIGHT_FIELDS  // constants, so that no instruction looks for them
const uint NLG_FIELDS[NLG_LIGHT_AXES] = NLG_LIGHT_FIELDS;
uint nlgFieldOf(int k) { return NLG_FIELDS[k]; }
#else
uint nlgFieldOf(int k) { return nlgHeader(nlgAxis(k) + 6).w; }
#endif
float nlgNumber(NlgRecord record, uint field) {
  return float(record.words[int(field & 7u)] >> (field >> 3 & 31u) & ((1u << (field >> 8 & 15u)) - 1u));
}
float nlgOffset(uint field) { return float(int(field) >> 16); }

// How much there is of each axis in a group, by shares of probes, over the grid's scale.
struct NlgAlong {
  float axis[27];
};
NlgAlong nlgAlongAxes(NlgShares shares, int group) {
  NlgAlong along;
  for (int k = 0; k < NLG_LIGHT_AXES; ++k) along.axis[k] = 0.0f;
  float scales = 0.0f;
  NLG_UNROLL for (int c = 0; c < 8; ++c) {
    if (shares.share[c] > 0.0f) {
      NlgRecord record = nlgRecordOf(shares.record[c] + group * NLG_GROUP_FOURS);
      float scale = shares.share[c] * record.scale;
      scales += scale;
      for (int k = 0; k < NLG_LIGHT_AXES; ++k) along.axis[k] += scale * nlgNumber(record, nlgFieldOf(k));
    }
  }
  for (int k = 0; k < NLG_LIGHT_AXES; ++k) along.axis[k] += scales * nlgOffset(nlgFieldOf(k));
  return along;
}

// Of a probe's light over all directions, over the grid's scale.
float nlgLuminanceOf(int record) {
  float all = 0.0f;
  for (int group = 0; group < NLG_GROUP_COUNT; ++group) {
    NlgRecord light = nlgRecordOf(record + group * NLG_GROUP_FOURS);
    vec3 colour = vec3(0.2126f, 0.7152f, 0.0722f) * nlgColour(group);
    float sum = 0.0f;
    for (int k = 0; k < NLG_LIGHT_AXES; ++k) {
      vec4 mean = uintBitsToFloat(nlgHeader(nlgAxis(k) + 6));
      sum += (nlgNumber(light, nlgFieldOf(k)) + nlgOffset(nlgFieldOf(k))) * dot(colour, vec3(mean.x, mean.y, mean.z));
    }
    all += light.scale * sum;
  }
  return max(0.0f, all);
}

// position_m   in the frame of the level
NlgShares nlgSharesAt(vec3 position_m) {
  NlgShares shares;
  shares.status = NLG_LIT;
  shares.certainty = 0.0f;
  NLG_UNROLL for (int c = 0; c < 8; ++c) {
    shares.record[c] = 0;
    shares.share[c] = 0.0f;
  }
  vec4 frame = uintBitsToFloat(nlgHeader(0));
  vec3 units = (position_m - vec3(frame.x, frame.y, frame.z)) * frame.w;
  NlgCell cell = nlgFindCell(units);
  if (!cell.found) {
    shares.status = NLG_OUTSIDE;
#ifdef NLG_NEAR
    cell = nlgFindNearCell(units);
#endif
    if (!cell.found) return shares;
  }

  // weights lack the factor 1 / (1 - residue), which all have
  float sum = 0.0f, believed = 0.0f, tents[8];
  NLG_UNROLL for (int c = 0; c < 8; ++c) {
    NlgCorner corner = nlgCornerOf(cell, c);
    // at a place that is that of a probe without weight the tents of all others end: then all count alike
    tents[c] = (corner.kind & 7) == NLG_KIND_NONE ? 0.0f : max(1e-20f, corner.tent * corner.ratio);
    float above = nlgTentShare(corner) - NLG_RESIDUE, weight = above * corner.tent * corner.ratio;
    shares.record[c] = corner.record;
    shares.share[c] = weight >= NLG_LEAST_WEIGHT * (1.0f - NLG_RESIDUE) ? weight : 0.0f;
    sum += shares.share[c];
    believed += shares.share[c] * above;
  }
  if (sum > 0.0f) {
    shares.certainty = min(1.0f, believed / (NLG_RESIDUE * sum));
    NLG_UNROLL for (int c = 0; c < 8; ++c) shares.share[c] *= shares.certainty / sum;
  }
  if (shares.certainty == 1.0f) return shares;

  // what the certainty lacks: tents over the square of the light that their probes hold
  float luminance[8], tent_sum = 0.0f, light = 0.0f;
  NLG_UNROLL for (int c = 0; c < 8; ++c) {
    luminance[c] = tents[c] > 0.0f ? nlgLuminanceOf(shares.record[c]) : 0.0f;
    tent_sum += tents[c];
    light += tents[c] * luminance[c];
  }
  if (shares.status == NLG_LIT) shares.status = tent_sum > 0.0f ? NLG_FAINT : NLG_UNLIT;
  if (!(tent_sum > 0.0f)) return shares;
  float mean = light / tent_sum + 1e-20f, dark_sum = 0.0f;
  NLG_UNROLL for (int c = 0; c < 8; ++c) {
    float darker = mean / (luminance[c] + NLG_DARKEST_FLOOR * mean);
    tents[c] *= darker * darker;
    dark_sum += tents[c];
  }
  NLG_UNROLL for (int c = 0; c < 8; ++c) shares.share[c] += (1.0f - shares.certainty) / dark_sum * tents[c];
  return shares;
}

// normal   length 1
vec3 nlgBlendedIrradiance(NlgShares shares, vec3 normal) {
  NlgBasis basis = nlgBasisOf(normal);
  vec3 irradiance = vec3(0.0f), mean_sum = vec3(0.0f);  // over all normals
  for (int group = 0; group < NLG_GROUP_COUNT; ++group) {
    vec3 colour = nlgColour(group);
    if (colour == vec3(0.0f)) continue;
    NlgAlong along = nlgAlongAxes(shares, group);
    for (int k = 0; k < NLG_LIGHT_AXES; ++k) {
      vec3 of_axis;
      for (int channel = 0; channel < 3; ++channel) {
        int head = nlgAxis(k) + 2 * channel;
        of_axis[channel] =
            dot(basis.low, uintBitsToFloat(nlgHeader(head))) + dot(basis.high, uintBitsToFloat(nlgHeader(head + 1)));
      }
      vec4 mean = uintBitsToFloat(nlgHeader(nlgAxis(k) + 6));
      vec3 part = along.axis[k] * colour;
      mean_sum += part * (basis.mean * vec3(mean.x, mean.y, mean.z));
      irradiance += part * of_axis;
    }
  }
  irradiance = max(irradiance + mean_sum, NLG_IRRADIANCE_FLOOR * mean_sum);
  return max(irradiance * uintBitsToFloat(nlgHeader(3).x), vec3(0.0f));
}

// position_m   in the frame of the level
// normal       length 1
NlgLight nlgIrradiance(vec3 position_m, vec3 normal) {
  NlgShares shares = nlgSharesAt(position_m);
  NlgLight light;
  light.irradiance = nlgBlendedIrradiance(shares, normal);
  light.status = shares.status;
  return light;
}

// position_m   in the frame of the level
NlgRadiance nlgRadiance(vec3 position_m) {
  NlgShares shares = nlgSharesAt(position_m);
  NlgRadiance radiance;
  for (int i = 0; i < 9; ++i) radiance.sh[i] = vec3(0.0f);
  for (int group = 0; group < NLG_GROUP_COUNT; ++group) {
    vec3 colour = nlgColour(group) * uintBitsToFloat(nlgHeader(3).x);
    NlgAlong along = nlgAlongAxes(shares, group);
    for (int k = 0; k < NLG_LIGHT_AXES; ++k) {
      vec4 mean = uintBitsToFloat(nlgHeader(nlgAxis(k) + 6));
      radiance.sh[0] += along.axis[k] * colour * vec3(mean.x, mean.y, mean.z);
      for (int channel = 0; channel < 3; ++channel) {
        int head = nlgAxis(k) + 2 * channel;
        vec4 low = uintBitsToFloat(nlgHeader(head)), high = uintBitsToFloat(nlgHeader(head + 1));
        for (int i = 0; i < 4; ++i) {
          radiance.sh[i + 1][channel] += along.axis[k] * colour[channel] * low[i];
          radiance.sh[i + 5][channel] += along.axis[k] * colour[channel] * high[i];
        }
      }
    }
  }
  radiance.certainty = shares.certainty;
  radiance.status = shares.status;
  return radiance;
}
