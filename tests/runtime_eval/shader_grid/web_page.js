// A shader grid in a browser: look-ups at a list of places, by WebGL 2 or by WebGPU, and what they differ by from lookUpIrradiance.
// The page defines kFiles (name -> base64) and kTexts (name -> text); each function returns what web_test.py judges.
'use strict';

function bytesOf(name) {
  return Uint8Array.from(atob(kFiles[name]), (c) => c.charCodeAt(0));
}
function floatsOf(name) {
  return new Float32Array(bytesOf(name).buffer);
}

// got, expected: 4 floats a place: irradiance, status
function compareLights(got, expected) {
  const result = {places: expected.length / 4, other_status: 0, above: 0, largest: 0, lit: 0};
  for (let i = 0; i < expected.length; i += 4) {
    if (got[i + 3] !== expected[i + 3]) ++result.other_status;
    result.lit += expected[i + 3] < 2;
    for (let c = i; c < i + 3; ++c) {
      const off = Math.abs(got[c] - expected[c]) / Math.max(1, expected[c]);
      // NaN is no agreement
      if (!(off <= 1e-3)) ++result.above;
      if (off > result.largest) result.largest = off;
    }
  }
  return result;
}

// ---- WebGL 2: the grid and the places are textures, a place is a pixel

const kPlacesARow = 64, kGridRow = 2048;
const kVertex = `#version 300 es
void main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0, float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;
const fragmentText = () => `#version 300 es
precision highp float;
precision highp int;
uniform highp usampler2D grid;
uniform highp sampler2D places;
out vec4 answer;
uvec4 nlgFour(int i) { return texelFetch(grid, ivec2(i & 2047, i >> 11), 0); }
uvec4 nlgHeader(int i) { return nlgFour(i); }
uint nlgWord(int i) { return nlgFour(i >> 2)[i & 3]; }
${kTexts['look_up.glsl']}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 position_m = texelFetch(places, ivec2(2 * pixel.x, pixel.y), 0).xyz;
  vec3 normal = texelFetch(places, ivec2(2 * pixel.x + 1, pixel.y), 0).xyz;
  NlgLight light = nlgIrradiance(position_m, normal);
  answer = vec4(light.irradiance, float(light.status));
}`;

function lookUpByWebGL() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return {missing: 'this browser has no WebGL 2'};
  if (!gl.getExtension('EXT_color_buffer_float')) return {missing: 'this WebGL 2 does not write floats'};
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, fragmentText()]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);

  const texture = (unit, format, width, height, layout, type, numbers) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    if (numbers) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, layout, type, numbers);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return gl.getParameter(gl.TEXTURE_BINDING_2D);
  };
  const bytes = bytesOf('grid.bin'), rows = Math.ceil(bytes.length / 16 / kGridRow);
  const words = new Uint32Array(4 * kGridRow * rows);
  words.set(new Uint32Array(bytes.buffer));
  texture(0, gl.RGBA32UI, kGridRow, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
  const places = floatsOf('places.bin'), height = places.length / 8 / kPlacesARow;
  texture(1, gl.RGBA32F, 2 * kPlacesARow, height, gl.RGBA, gl.FLOAT, places);
  const answer = texture(2, gl.RGBA32F, kPlacesARow, height);
  gl.uniform1i(gl.getUniformLocation(program, 'grid'), 0);
  gl.uniform1i(gl.getUniformLocation(program, 'places'), 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, answer, 0);
  gl.viewport(0, 0, kPlacesARow, height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const got = new Float32Array(4 * kPlacesARow * height);
  gl.readPixels(0, 0, kPlacesARow, height, gl.RGBA, gl.FLOAT, got);
  if (gl.getError() !== gl.NO_ERROR) throw new Error('WebGL reports an error');
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  return {device: gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER), look_up: compareLights(got, floatsOf('lights.bin'))};
}

// ---- WebGPU: as on Vulkan

const kCaller = `
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> lights: array<vec4f>;
@compute @workgroup_size(64) fn look_up(@builtin(global_invocation_id) id: vec3u) {
  var position_m = places[2 * id.x].xyz;
  var normal = places[2 * id.x + 1].xyz;
  let light = nlgIrradiance(&position_m, &normal);
  lights[id.x] = vec4f(light.irradiance, f32(light.status));
}`;

async function lookUpByWebGPU() {
  const adapter = navigator.gpu && await navigator.gpu.requestAdapter();
  if (!adapter) return {missing: 'this browser has no WebGPU'};
  const device = await adapter.requestDevice();
  device.pushErrorScope('validation');
  const buffer = (bytes, usage) => {
    const made = device.createBuffer({size: bytes.length, usage: usage | GPUBufferUsage.COPY_DST});
    device.queue.writeBuffer(made, 0, bytes);
    return made;
  };
  const grid = buffer(bytesOf('grid.bin'), GPUBufferUsage.STORAGE);
  const readable = (size) => device.createBuffer({size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ});
  const commands = device.createCommandEncoder();
  const dispatch = (code, entryPoint, resources, groups) => {
    const pipeline = device.createComputePipeline({layout: 'auto', compute: {module: device.createShaderModule({code}), entryPoint}});
    const entries = resources.map((resource, binding) => ({binding, resource}));
    const pass = commands.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, device.createBindGroup({layout: pipeline.getBindGroupLayout(0), entries}));
    pass.dispatchWorkgroups(...groups);
    pass.end();
  };

  const places = bytesOf('places.bin'), light_size = places.length / 2, light_copy = readable(light_size);
  const lights = device.createBuffer({size: light_size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC});
  dispatch(kTexts['look_up.wgsl'] + kCaller, 'look_up', [{buffer: grid}, {buffer: buffer(places, GPUBufferUsage.STORAGE)}, {buffer: lights}],
           [places.length / 32 / 64]);
  commands.copyBufferToBuffer(lights, 0, light_copy, 0, light_size);

  const box = bytesOf('box.bin'), count = [...new Uint32Array(box.buffer, 32, 3)];
  const size = [count[0], count[1], 7 * count[2]], pitch = Math.ceil(8 * size[0] / 256) * 256;
  const texture = device.createTexture({size, dimension: '3d', format: 'rgba16float', usage: GPUTextureUsage.STORAGE_BINDING | GPUTextureUsage.COPY_SRC});
  dispatch(kTexts['resample.wgsl'], 'main', [{buffer: grid}, {buffer: buffer(box, GPUBufferUsage.UNIFORM)}, texture.createView()], count.map((n) => Math.ceil(n / 4)));
  const texel_copy = readable(pitch * size[1] * size[2]);
  commands.copyTextureToBuffer({texture}, {buffer: texel_copy, bytesPerRow: pitch, rowsPerImage: size[1]}, size);
  device.queue.submit([commands.finish()]);
  const error = await device.popErrorScope();
  if (error) throw new Error(error.message);
  await Promise.all([light_copy.mapAsync(GPUMapMode.READ), texel_copy.mapAsync(GPUMapMode.READ)]);
  const halves = new Uint16Array(texel_copy.getMappedRange());
  const scale = new Float32Array(bytesOf('grid.bin').buffer, 48, 1)[0];
  return {
    device: `${adapter.info.vendor} ${adapter.info.architecture}`,
    look_up: compareLights(new Float32Array(light_copy.getMappedRange()), floatsOf('lights.bin')),
    resampled: compareTexels((x, y, z, k) => halfAt(halves, ((Math.floor(k / 4) * count[2] + z) * size[1] + y) * pitch / 2 + 4 * x + k % 4), count, scale),
  };
}

function halfAt(halves, i) {
  const bits = halves[i], exponent = bits >> 10 & 31, fraction = bits & 1023, sign = bits >> 15 ? -1 : 1;
  if (exponent === 31) return NaN;
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15));
}

// numberAt(x, y, z, k)   number k of a texel, over the scale but for the last
function compareTexels(numberAt, count, scale) {
  const expected = floatsOf('texels.bin'), result = {texels: expected.length / 28, other_say: 0, above: 0, lit: 0};
  let at = 0;
  for (let z = 0; z < count[2]; ++z) {
    for (let y = 0; y < count[1]; ++y) {
      for (let x = 0; x < count[0]; ++x, at += 28) {
        // a say of 0 or 1 is exact; between them shares of tents are off by 1e-5 as light is, over a residue of .05, and a half is
        // rounded either way
        const say = expected[at + 27], most = say === 0 || say === 1 ? 0 : 2e-4 + say / 1024;
        if (!(Math.abs(numberAt(x, y, z, 27) - say) <= most)) ++result.other_say;
        result.lit += say === 1;
        for (let k = 0; k < 27; ++k) {
          const value = expected[at + k], off = Math.abs(numberAt(x, y, z, k) * scale - value);
          // and a half that was rounded either way
          if (!(off <= 1e-3 * Math.max(1, expected[at]) + Math.abs(value) / 1024)) ++result.above;
        }
      }
    }
  }
  return result;
}
