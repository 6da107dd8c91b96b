precision highp float;
in vec3 place;
flat in vec3 emitted;  // below 0: the sky
uniform vec3 zenith, horizon, ground, cameraPosition;
layout(location = 0) out vec4 colour;

void main() {
  vec3 direction = normalize(place - cameraPosition);
  vec3 sky = direction.y < 0.0 ? ground : horizon + (zenith - horizon) * direction.y;
  colour = vec4(emitted.x < 0.0 ? sky : emitted, 1.0);
}
