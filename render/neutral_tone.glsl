// Khronos PBR Neutral, the tone curve of glTF viewers: https://github.com/KhronosGroup/ToneMapping, PBR_Neutral. Up to .8 colours keep
// their hue and lose .04 of their light; above, they approach 1 and white.
//
// One text for C++ (tone.cpp, by GLM's names) and for the shader of nlg-view's page: what both draw is the same.
vec3 neutralTone(vec3 colour) {
  const float start = 0.8f - 0.04f, desaturation = 0.15f, left = 1.0f - start;
  float least = min(colour.r, min(colour.g, colour.b));
  colour -= least < 0.08f ? least - 6.25f * least * least : 0.04f;
  float peak = max(colour.r, max(colour.g, colour.b));
  if (peak < start) return colour;
  float new_peak = 1.0f - left * left / (peak + left - start);
  colour *= new_peak / peak;
  return mix(vec3(new_peak), colour, 1.0f / (desaturation * (peak - new_peak) + 1.0f));
}
