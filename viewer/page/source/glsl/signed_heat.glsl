// Blue below 0, red above.
vec3 signedHeat(float value) {
  float size = clamp(abs(value), 0.0, 1.0);
  vec3 strong = value > 0.0 ? vec3(0.75, 0.05, 0.05) : vec3(0.05, 0.2, 0.75);
  return mix(vec3(0.93), strong, sqrt(size));
}
