precision highp float;
in vec3 shade;
in float strength;
uniform float opacity;
layout(location = 0) out vec4 colour;

void main() {
  // sparser with distance instead of transparent: a colour keeps its own w
  float grain = fract(sin(dot(floor(gl_FragCoord.xy), vec2(12.9898, 78.233))) * 43758.5453);
  if (grain >= strength * opacity) discard;
  colour = vec4(shade, 0.0);
}
