// Methods that light surfaces: the materials that ask them, and what these read.
import * as THREE from 'three';
import surfaceVertex from './glsl/surface.vert.glsl';
import signedHeat from './glsl/signed_heat.glsl';
import looksText from './glsl/looks.glsl';
import surfaceFragment from './glsl/surface.frag.glsl';
import gridReads from './glsl/grid.glsl';
import gridLight from './glsl/grid_light.glsl';
import ddgiLight from './glsl/ddgi_light.glsl';

const TEXELS_A_ROW = 2048;
export const PRECISION = 'precision highp float;\nprecision highp int;\nprecision highp sampler2D;\nprecision highp usampler2D;\n';

// Words, four a texel; what fills the last row is 0.
function wordTexture(words) {
  const rows = Math.max(1, Math.ceil(words.length / 4 / TEXELS_A_ROW));
  const texels = new Uint32Array(4 * TEXELS_A_ROW * rows);
  texels.set(words);
  const texture = new THREE.DataTexture(texels, TEXELS_A_ROW, rows, THREE.RGBAIntegerFormat, THREE.UnsignedIntType);
  texture.internalFormat = 'RGBA32UI';
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

// What all that is drawn of a scene reads of its images: texts before the shaders, and uniforms. A scene without any has none.
export function looksOf(scene) {
  if (!scene.images_of) return { vertex: '', fragment: looksText, uniforms: {} };
  const { side, count } = scene.images_of;
  const texels = count > 0 ? scene.images : new Uint8Array(4 * side * side).fill(255);
  const images = new THREE.DataArrayTexture(texels, side, side, Math.max(1, count));
  images.colorSpace = THREE.SRGBColorSpace;
  images.wrapS = images.wrapT = THREE.RepeatWrapping;
  images.magFilter = THREE.LinearFilter;
  images.minFilter = THREE.LinearMipmapLinearFilter;
  images.generateMipmaps = true;
  images.anisotropy = 4;
  images.needsUpdate = true;
  return { vertex: '#define LOOKS\n', fragment: `#define LOOKS\n${looksText}`, uniforms: { images: { value: images } } };
}

// The text that says what irradianceAt is, and its uniforms.
function gridProgram(data, lookUp, light) {
  const defines = data.defines.map((define) => `#define ${define}\n`).join('');
  return {
    text: `#define HEADER_COUNT ${data.header_count}\n${defines}#define NLG_NEAR\n${gridReads}${lookUp}${light}`,
    uniforms: { words: { value: wordTexture(data.words) }, head: { value: data.words.slice(0, 4 * data.header_count) } },
  };
}

function ddgiProgram(data, lookUp) {
  const program = gridProgram(data, lookUp, ddgiLight);
  program.uniforms.maps = { value: wordTexture(data.maps) };
  program.uniforms.irradiance_scale = { value: data.scale };
  return program;
}

const PROGRAMS = { grid: (data, lookUp) => gridProgram(data, lookUp, gridLight), ddgi: ddgiProgram };

// What a light grid can show of itself, and the text that makes it so.
const SHOWS = { light: '', share: '#define SHOWS_SHARE\n', leaks: '#define SHOWS_LEAKS\n' };

// A method that lights surfaces as they are drawn.
class RenderedMethod {
  constructor(entry, data, lookUp, looks) {
    this.name = entry.name;
    this.looks = looks;
    this.isGrid = data.kind === 'grid';
    const program = PROGRAMS[data.kind](data, lookUp);
    this.uniforms = { ...program.uniforms, offset_m: { value: 0.02 }, chosen_record: { value: 0 }, heat_full: { value: 1 } };
    this.groups = data.groups ?? []; // of light; their colours stand in the head of the grid, as floats
    if (this.groups.length > 0) this.colours = new Float32Array(this.uniforms.head.value.buffer).subarray(4 * data.first_colour);
    this.begins = new Map(this.groups.map((name, group) => [name, this.colours[4 * group]])); // by group: its factor in the file
    this.text = program.text + signedHeat + looks.fragment + surfaceFragment;
  }

  // colours   of each group of light three factors, linear
  mix(colours) {
    colours.forEach((colour, group) => this.colours.set(colour, 4 * group));
  }

  // shown   light, share, leaks; what a method cannot show of itself is its light
  // litAt   a place at which light is asked for, whatever is lit; none: before each point of the surface
  material(shown, side, litAt = new THREE.Vector4(0, 0, 0, 0)) {
    return new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: this.looks.vertex + surfaceVertex,
      fragmentShader: PRECISION + (this.isGrid ? SHOWS[shown] ?? '' : '') + this.text,
      uniforms: { ...this.uniforms, ...this.looks.uniforms, litAt: { value: litAt } },
      side,
    });
  }
}

export const TRUTH = 'truth';

export class Methods {
  // data   that the scene is of
  constructor(scene, data) {
    this.scene = scene;
    this.data = data;
    this.looks = looksOf(scene);
    this.entries = new Map(scene.methods.map((entry) => [entry.name, entry]));
    this.made = new Map();
  }

  has(name) {
    return this.entries.has(name) || (name === TRUTH && this.scene.has_truth);
  }
  get names() {
    return [...this.entries.keys(), ...(this.scene.has_truth ? [TRUTH] : [])];
  }
  titleOf(name) {
    return name === TRUTH ? 'path tracing' : this.entries.get(name).title;
  }

  // Reads it the first time.
  async rendered(name) {
    if (!this.made.has(name)) {
      const data = await this.data.load(`method-${name}`);
      this.made.set(name, new RenderedMethod(this.entries.get(name), data, this.scene.look_up, this.looks));
    }
    return this.made.get(name);
  }

  async truth(view) {
    const key = `${TRUTH}-${view}`;
    if (!this.made.has(key)) {
      const data = await this.data.load(key);
      const texture = new THREE.DataTexture(data.texels, data.width, data.height, THREE.RGBFormat, THREE.UnsignedInt5999Type);
      texture.internalFormat = 'RGB9_E5';
      texture.minFilter = texture.magFilter = THREE.LinearFilter;
      texture.needsUpdate = true;
      this.made.set(key, { texture, aspect: data.width / data.height, unit: data.unit });
    }
    return this.made.get(key);
  }

  // What the graphics card holds of them.
  dispose() {
    this.looks.uniforms.images?.value.dispose();
    for (const { texture, uniforms } of this.made.values()) {
      texture?.dispose();
      for (const { value } of Object.values(uniforms ?? {})) if (value?.isTexture) value.dispose();
    }
  }
}
