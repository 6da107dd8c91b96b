// Positions relative to the scene's origin.
precision highp float;
in vec3 position;
in vec3 normal;
in vec3 albedo;
in vec3 shine;
#ifdef LOOKS
in vec4 base_at, shine_at;
in vec2 transmissive_share;
out vec4 base_look, shine_look;
out vec2 transmissive;
#endif
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
out vec3 place;
out vec3 facing;
out vec3 reflected;
flat out vec3 emitted;

void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  place = world.xyz;
  facing = mat3(modelMatrix) * normal;
  reflected = albedo;
  emitted = shine;
#ifdef LOOKS
  base_look = base_at;
  shine_look = shine_at;
  transmissive = transmissive_share;
#endif
  gl_Position = projectionMatrix * viewMatrix * world;
}
