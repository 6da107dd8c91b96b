// What a surface, a ball or a figure sends to the camera: albedo x irradiance / pi + emission. What stands before this text says
// what irradiance is:
//
//     vec3 irradianceAt(vec3 place, vec3 normal)    >= 0
//
// or, in its place, what shows something else of a light grid: SHOWS_SHARE shareOf(place, record), SHOWS_LEAKS leakAt(place, normal).
in vec3 place;
in vec3 facing;
in vec3 reflected;
flat in vec3 emitted;
uniform float offset_m;      // before the surface
uniform vec4 litAt;          // w > 0: light is asked for at this one place, as engines do for small things
uniform uint chosen_record;  // of that probe
uniform float heat_full;     // the irradiance whose colour is the last
layout(location = 0) out vec4 colour;  // w = 1: radiance; 0: a colour as it is shown

// Surfaces keep their shape where a colour says nothing.
vec3 shaded(vec3 normal) { return vec3(0.55 + 0.2 * normal.y + 0.1 * normal.x); }

void main() {
  leaveHolesOut();
  vec3 normal = normalize(gl_FrontFacing ? facing : -facing);
  vec3 at = litAt.w > 0.0 ? litAt.xyz : place + offset_m * normal;
#if defined(SHOWS_SHARE)
  float share = shareOf(at, chosen_record);
  vec3 hot = mix(vec3(1.0, 0.85, 0.3), vec3(0.8, 0.1, 0.05), share);
  colour = vec4(share > 0.0 ? hot * (0.6 + 0.4 * shaded(normal)) : 0.6 * shaded(normal), 0.0);
#elif defined(SHOWS_LEAKS)
  colour = vec4(signedHeat(leakAt(at, normal) / heat_full) * (0.5 + 0.5 * shaded(normal)), 0.0);
#else
  vec3 sent = reflected * imageAt(base_look).rgb * irradianceAt(at, normal) * (1.0 / 3.14159265);
  colour = vec4(sent + (gl_FrontFacing ? emitted * imageAt(shine_look).rgb : vec3(0.0)), 1.0);
#endif
}
