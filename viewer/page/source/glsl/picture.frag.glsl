// Two methods side by side, or their difference, as they are shown: radiance times the exposure, through neutralTone, in sRGB.
in vec2 at;
uniform sampler2D left, right;
uniform vec2 left_scale, right_scale;  // of a stored picture: how much of it is seen along x and y; 0: rendered
uniform vec2 units;                    // what a stored number of 1 stands for
uniform float divider, exposure, texel;
uniform bool is_difference;
layout(location = 0) out vec4 colour;

vec4 sampled(sampler2D picture, vec2 scale, float unit) {
  if (scale == vec2(0.0)) return texture(picture, at);
  vec2 place = (at - 0.5) * scale + 0.5;
  if (place != clamp(place, 0.0, 1.0)) return vec4(vec3(0.2), 0.0);
  // rows from the top
  return vec4(texture(picture, vec2(place.x, 1.0 - place.y)).rgb * unit, 1.0);
}
vec3 encoded(vec3 linear) {
  vec3 v = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, 12.92 * v, lessThanEqual(v, vec3(0.0031308)));
}
vec3 shown(vec4 sample_) { return mix(sample_.rgb, encoded(neutralTone(sample_.rgb * exposure)), sample_.w); }

void main() {
  vec4 a = sampled(left, left_scale, units.x), b = sampled(right, right_scale, units.y);
  if (is_difference && a.w * b.w == 0.0) {
    colour = vec4(vec3(0.2), 1.0);
    return;
  }
  if (is_difference) {
    float value = dot(b.rgb - a.rgb, vec3(0.2126, 0.7152, 0.0722)) * exposure / 0.18;
    colour = vec4(signedHeat(value), 1.0);
    return;
  }
  vec3 result = shown(at.x < divider ? a : b);
  if (divider > 0.0 && divider < 1.0 && abs(at.x - divider) < texel) result = vec3(1.0);
  colour = vec4(result, 1.0);
}
