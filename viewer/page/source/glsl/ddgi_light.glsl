// DDGI as shipped, as light/methods/ddgi.cpp has it: octahedral maps of irradiance (6 x 6, 10 bits) and depth (14 x 14, two
// moments). Probes are those of a light grid of bare tents, in the order of the maps.
uniform highp usampler2D maps;  // 236 words a probe, four a texel, 2048 texels a row
uniform float irradiance_scale;
const int MAP_WORDS = 236, IRRADIANCE_SIDE = 6, DEPTH_SIDE = 14;
const float NORMAL_BIAS_M = 0.02;

uint mapWord(int probe, int i) {
  int word = probe * MAP_WORDS + i, four = word >> 2;
  return texelFetch(maps, ivec2(four & 2047, four >> 11), 0)[word & 3];
}

// On [-1, 1] squared.
vec2 octahedralPlace(vec3 direction) {
  vec3 d = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
  if (d.z >= 0.0) return d.xy;
  return vec2(d.x >= 0.0 ? 1.0 - abs(d.y) : abs(d.y) - 1.0, d.y >= 0.0 ? 1.0 - abs(d.x) : abs(d.x) - 1.0);
}

// The number of a texel that may lie one beyond the rim.
int wrappedTexel(int x, int y, int side) {
  if (x < 0 || x >= side) {
    x = x < 0 ? 0 : side - 1;
    y = side - 1 - y;
  }
  if (y < 0 || y >= side) {
    y = y < 0 ? 0 : side - 1;
    x = side - 1 - x;
  }
  return y * side + x;
}

vec3 storedIrradiance(int probe, vec3 direction) {
  vec2 at = (octahedralPlace(direction) * 0.5 + 0.5) * float(IRRADIANCE_SIDE) - 0.5;
  ivec2 low = clamp(ivec2(floor(at)), ivec2(-1), ivec2(IRRADIANCE_SIDE - 1));
  vec2 share = at - vec2(low);
  vec3 sum = vec3(0.0);
  for (int c = 0; c < 4; ++c) {
    ivec2 high = ivec2(c & 1, c >> 1);
    uint word = mapWord(probe, 1 + wrappedTexel(low.x + high.x, low.y + high.y, IRRADIANCE_SIDE));
    vec2 part = mix(vec2(1.0) - share, share, vec2(high));
    sum += part.x * part.y * vec3(uvec3(word, word >> 10, word >> 20) & 1023u) / 1023.0;
  }
  return sum;
}

vec2 storedDepth(int probe, vec3 direction) {
  vec2 at = (octahedralPlace(direction) * 0.5 + 0.5) * float(DEPTH_SIDE) - 0.5;
  ivec2 low = clamp(ivec2(floor(at)), ivec2(-1), ivec2(DEPTH_SIDE - 1));
  vec2 share = at - vec2(low), sum = vec2(0.0);
  for (int c = 0; c < 4; ++c) {
    ivec2 high = ivec2(c & 1, c >> 1);
    vec2 part = mix(vec2(1.0) - share, share, vec2(high));
    sum += part.x * part.y * unpackHalf2x16(mapWord(probe, 37 + wrappedTexel(low.x + high.x, low.y + high.y, DEPTH_SIDE)));
  }
  return sum;
}

float seen(int probe, vec3 way) {
  float distance = length(way);
  if (!(distance > 0.0)) return 1.0;
  vec2 moments = storedDepth(probe, way / distance);
  if (distance <= moments.x) return 1.0;
  float variance = abs(moments.x * moments.x - moments.y), beyond = distance - moments.x;
  float bound = variance / (variance + beyond * beyond);
  return bound * bound * bound;
}

vec3 irradianceAt(vec3 place, vec3 normal) {
  vec4 frame = uintBitsToFloat(nlgHeader(0));
  vec3 biased = place + NORMAL_BIAS_M * normal;
  NlgCell cell = nlgFindCell((biased - frame.xyz) * frame.w);
  vec3 alpha = cell.from_low;
  if (!cell.found) {
    cell = nlgFindCell((place - frame.xyz) * frame.w);
    if (!cell.found) return vec3(0.0);
    alpha = clamp(cell.from_low + (biased - place) * frame.w / float(1 << cell.side_log2), vec3(0.0), vec3(1.0));
  }
  float side_m = float(1 << cell.side_log2) / frame.w;
  uvec4 records = nlgHeader(NLG_CLASSES);
  vec3 roots = vec3(0.0);
  float weights = 0.0;
  for (int c = 0; c < 8; ++c) {
    int record = nlgCornerOf(cell, c).record;
    int probe = (record - int(records.y)) / int(records.z);
    if (mapWord(probe, 0) == 0u) continue;
    vec3 high = vec3(c & 1, c >> 1 & 1, c >> 2);
    vec3 trilinear = max(mix(vec3(1.0) - alpha, alpha, high), vec3(0.001));
    vec3 to_biased = (alpha - high) * side_m, to_probe = to_biased - (biased - place);
    to_probe = -to_probe;
    float distance = length(to_probe);
    float wrap = distance > 0.0 ? (dot(to_probe / distance, normal) + 1.0) * 0.5 : 1.0;
    float weight = (wrap * wrap + 0.2) * max(0.05, seen(probe, to_biased));
    weight = max(1e-6, weight);
    if (weight < 0.2) weight *= weight * weight / 0.04;
    weight *= trilinear.x * trilinear.y * trilinear.z;
    roots += weight * pow(storedIrradiance(probe, normal), vec3(2.5));
    weights += weight;
  }
  if (!(weights > 0.0)) return vec3(0.0);
  roots /= weights;
  return roots * roots * 6.28318531 * irradiance_scale;
}
