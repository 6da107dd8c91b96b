// A light grid in three.js (0.187, WebGLRenderer): every pixel looks up in the grid itself, and nothing is resampled.
//
//     const grid = await NeuralLightGrid.load('level');    // a folder with grid.bin and look_up.glsl
//     grid.applyTo(material);                               // Lambert, Phong, Toon, Standard, Physical: they have its light from now on
//
// What it adds is indirect irradiance, beside that of three.js's own lights, for the surface as it is drawn: moved, instanced, skinned
// or displaced, with its normal map, and facing the camera where a material has two sides. WebGPURenderer asks no hook of this kind:
// three_light_grid_webgpu.js is for it.
import { DataTexture, NearestFilter, RGBAIntegerFormat, UnsignedIntType, Vector3 } from 'three';

const TEXELS_A_ROW = 2048; // what every WebGL 2 offers
const CLASS_COUNT_WORD = 13, AXIS_COUNT_WORD = 16, GROUP_COUNT_WORD = 19, CLASSES = 5, HEADS_A_CLASS = 2, HEADS_AN_AXIS = 7, FIELD_WORD = 27; // of grid.bin's head (shader_grid.h)
const INCLUDED = '#include <lights_fragment_begin>';

const gridOfMaterial = new WeakMap();

async function read(url, form) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response[form]();
}

// Four words a texel; what fills the last row is 0.
function wordTexture(words) {
  const rows = Math.ceil(words.length / 4 / TEXELS_A_ROW);
  const texels = new Uint32Array(4 * TEXELS_A_ROW * rows);
  texels.set(words);
  const texture = new DataTexture(texels, TEXELS_A_ROW, rows, RGBAIntegerFormat, UnsignedIntType);
  texture.internalFormat = 'RGBA32UI';
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

const readsOf = (headCount) => `
uniform highp usampler2D nlg_words;
uniform uvec4 nlg_head[${headCount}];
uniform vec3 nlg_position;
uniform float nlg_offset_m;
uniform float nlg_intensity;
uvec4 nlgFour(int i) { return texelFetch(nlg_words, ivec2(i & ${TEXELS_A_ROW - 1}, i / ${TEXELS_A_ROW}), 0); }
uvec4 nlgHeader(int i) { return nlg_head[i]; }
uint nlgWord(int i) { return nlgFour(i >> 2)[i & 3]; }
`;

// Both directions of the camera are known to the fragment, whatever the vertices went through.
const ADDED = `
#if defined( RE_IndirectDiffuse )
  vec3 nlg_place = ((vec4(geometryPosition, 1.0) - viewMatrix[3]) * viewMatrix).xyz;
  vec3 nlg_before = normalize((vec4(nonPerturbedNormal, 0.0) * viewMatrix).xyz);
  vec3 nlg_facing = normalize((vec4(geometryNormal, 0.0) * viewMatrix).xyz);
  irradiance += nlg_intensity * nlgIrradiance(nlg_place + nlg_offset_m * nlg_before - nlg_position, nlg_facing).irradiance;
#endif
`;

export class NeuralLightGrid {
  #uniforms;
  #colours; // of the groups of light, in the head
  #text;
  #materials = new Map(); // and the hooks that they had before

  // folder   its URL; with what nlg-export shader --format three-per-pixel wrote
  // throws   Error where one of the two files is not there, or they are of different grids
  static async load(folder) {
    const [bytes, lookUp] = await Promise.all([read(`${folder}/grid.bin`, 'arrayBuffer'), read(`${folder}/look_up.glsl`, 'text')]);
    return new NeuralLightGrid(new Uint32Array(bytes), lookUp);
  }

  // words    Uint32Array, grid.bin
  // lookUp   the text of look_up.glsl
  constructor(words, lookUp) {
    const classCount = words[CLASS_COUNT_WORD], axisCount = words[AXIS_COUNT_WORD], firstAxis = CLASSES + HEADS_A_CLASS * classCount;
    const fields = Array.from({ length: axisCount }, (_, k) => `${words[4 * (firstAxis + HEADS_AN_AXIS * k) + FIELD_WORD]}u`);
    // what the text holds of the grid as constants
    const constants = [`NLG_CLASS_COUNT ${classCount}`, `NLG_LIGHT_AXES ${axisCount}`, ...(axisCount > 0 ? [`NLG_LIGHT_FIELDS uint[](${fields.join(', ')})`] : [])];
    if (constants.some((constant) => !lookUp.includes(`#define ${constant}\n`))) throw new Error('grid.bin and look_up.glsl are not of one grid');
    const firstColour = firstAxis + HEADS_AN_AXIS * axisCount;
    const headCount = firstColour + words[GROUP_COUNT_WORD];
    this.groups = [...lookUp.matchAll(/^\/\/ light group \d+, .*? of the head: (.*)$/gm)].map((line) => line[1]);
    this.#text = readsOf(headCount) + lookUp;
    this.#uniforms = {
      nlg_words: { value: wordTexture(words) },
      nlg_head: { value: words.slice(0, 4 * headCount) },
      nlg_position: { value: new Vector3() },
      nlg_offset_m: { value: 0.02 },
      nlg_intensity: { value: 1 },
    };
    this.#colours = new Float32Array(this.#uniforms.nlg_head.value.buffer).subarray(4 * firstColour);
  }

  // Where the level's origin stands in the world: a Vector3.
  get position() {
    return this.#uniforms.nlg_position.value;
  }

  // So far before a surface its light is looked up, metres.
  get offset_m() {
    return this.#uniforms.nlg_offset_m.value;
  }
  set offset_m(value) {
    this.#uniforms.nlg_offset_m.value = value;
  }

  // What the light is multiplied by.
  get intensity() {
    return this.#uniforms.nlg_intensity.value;
  }
  set intensity(value) {
    this.#uniforms.nlg_intensity.value = value;
  }

  // Names of the groups of light that can be dimmed, coloured and switched; none: all light is one.
  groups;

  // name     of this.groups
  // colour   an array of three factors, linear; 1 to begin with, 0 of light states after the first
  // throws   Error where there is no such group, or a colour that is none
  setGroupColour(name, colour) {
    const group = this.groups.indexOf(name);
    if (group < 0) throw new Error(`no group of light '${name}'; there are ${this.groups.join(', ') || 'none'}`);
    if (colour?.length !== 3 || !colour.every(Number.isFinite)) throw new Error(`a colour of '${name}': expected three numbers, got ${colour}`);
    this.#colours.set(colour, 4 * group);
  }

  // A material's own onBeforeCompile is called as before. Does nothing where a material has this grid's light already. A clone of a
  // material has no light: three.js does not copy hooks.
  // materials   one, or an array, as meshes have them
  // throws      Error where one has another grid's light; as it is drawn, where three.js does not light it
  applyTo(materials) {
    for (const material of [materials].flat()) this.#applyTo(material);
  }

  #applyTo(material) {
    const other = gridOfMaterial.get(material);
    if (other === this) return;
    if (other) throw new Error(`${material.type} '${material.name}' has the light of another grid`);
    const { onBeforeCompile, customProgramCacheKey } = material;
    material.onBeforeCompile = (shader, renderer) => {
      onBeforeCompile.call(material, shader, renderer);
      this.#addTo(shader, material);
    };
    material.customProgramCacheKey = () => customProgramCacheKey.call(material) + onBeforeCompile.toString() + this.#text;
    material.needsUpdate = true;
    this.#materials.set(material, { onBeforeCompile, customProgramCacheKey });
    gridOfMaterial.set(material, this);
  }

  // The material is as it was before applyTo.
  removeFrom(material) {
    const before = this.#materials.get(material);
    if (!before) return;
    Object.assign(material, before, { needsUpdate: true });
    this.#materials.delete(material);
    gridOfMaterial.delete(material);
  }

  // All materials are as they were, and the graphics card's memory is free.
  dispose() {
    for (const material of [...this.#materials.keys()]) this.removeFrom(material);
    this.#uniforms.nlg_words.value.dispose();
  }

  #addTo(shader, material) {
    if (!shader.fragmentShader.includes(INCLUDED)) throw new Error(`${material.type} '${material.name}' is not lit by three.js: no ${INCLUDED}`);
    shader.fragmentShader = this.#text + shader.fragmentShader.replace(INCLUDED, INCLUDED + ADDED);
    Object.assign(shader.uniforms, this.#uniforms);
  }
}
