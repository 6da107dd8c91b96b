// Many small shapes: where each stands, how large it is, and its colour.
precision highp float;
in vec3 position;
in vec4 mark;  // place, size
in vec3 tint;
uniform mat4 viewMatrix, projectionMatrix;
uniform vec3 cameraPosition;
uniform float reach_m;  // farther than this nothing is drawn
uniform bool is_small;
out vec3 shade;
out float strength;

void main() {
  vec3 world = mark.xyz + mark.w * position;
  float distance = length(mark.xyz - cameraPosition);
  // nor what would fill the picture
  strength = distance < 6.0 * mark.w && is_small ? 0.0 : clamp(4.0 * (1.0 - distance / reach_m), 0.0, 1.0);
  shade = tint;
  gl_Position = strength > 0.0 ? projectionMatrix * viewMatrix * vec4(world, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
