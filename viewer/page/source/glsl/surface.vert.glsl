// Positions relative to the scene's origin.
precision highp float;
in vec3 position;
in vec3 normal;
in vec3 albedo;
in vec3 shine;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
out vec3 place;
out vec3 facing;
flat out vec3 reflected;
flat out vec3 emitted;

void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  place = world.xyz;
  facing = mat3(modelMatrix) * normal;
  reflected = albedo;
  emitted = shine;
  gl_Position = projectionMatrix * viewMatrix * world;
}
