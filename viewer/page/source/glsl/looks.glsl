// Images of a scene's surfaces, and what of a transmissive surface is drawn. Without LOOKS a surface is what its material's factors say.
#ifdef LOOKS
precision highp sampler2DArray;
in vec4 base_look;   // place on the base image; its layer from 1, 0 for none; wrapping
in vec4 shine_look;  // the same of the image that it shines by
in vec2 transmissive;        // opacity of the vertex; what is let through beside the image's alpha, below 0: opaque
uniform sampler2DArray images;

float wrappedPlace(float at, float wrap) {
  if (wrap > 1.5) return clamp(at, 0.5 / float(textureSize(images, 0).x), 1.0 - 0.5 / float(textureSize(images, 0).x));
  return wrap > 0.5 ? abs(mod(at - 1.0, 2.0) - 1.0) : at;
}
vec4 imageAt(vec4 look) {
  vec2 at = vec2(wrappedPlace(look.x, floor(look.w / 3.0 + 0.1)), wrappedPlace(look.y, mod(look.w, 3.0)));
  vec4 texel = texture(images, vec3(at, max(0.0, look.z - 1.0)));
  return look.z < 0.5 ? vec4(1.0) : texel;
}
// Sparser instead of transparent, so that no order of drawing matters: the same pixels for depth and colour.
void leaveHolesOut() {
  if (transmissive.y < 0.0) return;
  float opacity = imageAt(base_look).a * transmissive.x * (1.0 - transmissive.y);
  float grain = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
  if (opacity <= grain) discard;
}
#else
const vec4 base_look = vec4(0.0), shine_look = vec4(0.0);
vec4 imageAt(vec4 look) { return vec4(1.0); }
void leaveHolesOut() {}
#endif
