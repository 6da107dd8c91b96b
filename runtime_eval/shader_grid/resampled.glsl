// Irradiance out of a texture that resample.comp has filled. GLSL 4.50 and GLSL ES 3.00. Whoever includes it gives the texture:
//
//     vec4 nlgSlabs(vec3 at)    filtered linearly, clamped to the edge: textureLod(light, at, 0.0)

// share    of the box along each axis, [0, 1]
// depth    texels of the box along z
// normal   length 1
// returns  irradiance over the grid's scale; 0 where no texel around has light
vec3 nlgResampledIrradiance(vec3 share, float depth, vec3 normal) {
  // no texel of the next slab
  float z = clamp(share.z, 0.5f / depth, 1.0f - 0.5f / depth);
  vec4 fours[7];
  for (int slab = 0; slab < 7; ++slab) fours[slab] = nlgSlabs(vec3(share.x, share.y, (float(slab) + z) / 7.0f));
  vec4 a = fours[0], b = fours[1], c = fours[2], d = fours[3], e = fours[4], f = fours[5], g = fours[6];
  if (!(g.w > 0.0f)) return vec3(0.0f);
  vec3 n = normal;
  vec3 mean = 0.88622693f * a.xyz;
  vec3 sum = mean + 1.02332671f * (n.y * vec3(a.w, b.xy) + n.z * vec3(b.zw, c.x) + n.x * c.yzw) +
             0.85808553f * (n.x * n.y * d.xyz + n.y * n.z * vec3(d.w, e.xy) + n.x * n.z * f.yzw) +
             0.24770796f * (3.0f * n.z * n.z - 1.0f) * vec3(e.zw, f.x) + 0.42904277f * (n.x * n.x - n.y * n.y) * g.xyz;
  // at least kIrradianceFloor of a channel's mean over all normals (nlg/light_grid.h)
  return max(max(sum, 0.1f * mean) / g.w, vec3(0.0f));
}
