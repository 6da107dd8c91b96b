// The light grid that a Quake III level ships, as the engine blends it (light/methods/quake_grid_method.cpp).
uniform highp sampler2D cells;  // three texels a cell: ambient, directed, the way to the light; 1023 texels a row
uniform vec3 first_m, step_m;
uniform ivec3 cell_count;
uniform float ambient_scale, directed_scale;

vec3 cellPart(int cell, int part) {
  int texel = 3 * cell + part;
  return texelFetch(cells, ivec2(texel % 1023, texel / 1023), 0).xyz;
}

vec3 irradianceAt(vec3 place, vec3 normal) {
  vec3 inside = clamp((place - first_m) / step_m, vec3(0.0), vec3(cell_count - 1));
  ivec3 low = min(ivec3(inside), max(ivec3(0), cell_count - 2));
  vec3 share = inside - vec3(low);
  vec3 ambient = vec3(0.0), directed = vec3(0.0), direction = vec3(0.0);
  float weights = 0.0;
  for (int c = 0; c < 8; ++c) {
    ivec3 high = ivec3(c & 1, c >> 1 & 1, c >> 2), at = min(low + high, cell_count - 1);
    vec3 part = mix(vec3(1.0) - share, share, vec3(high));
    int cell = (at.z * cell_count.y + at.y) * cell_count.x + at.x;
    vec3 its_ambient = cellPart(cell, 0);
    if (its_ambient == vec3(0.0)) continue;  // in solid
    float weight = part.x * part.y * part.z;
    weights += weight;
    ambient += weight * its_ambient;
    directed += weight * cellPart(cell, 1);
    direction += weight * cellPart(cell, 2);
  }
  if (!(weights > 0.0)) return vec3(0.0);
  float size = length(direction);
  float cosine = size > 0.0 ? max(0.0, dot(normal, direction / size)) : 0.0;
  return (ambient_scale * ambient + directed_scale * cosine * directed) / weights;
}
