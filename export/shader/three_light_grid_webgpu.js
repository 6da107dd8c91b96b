// A light grid in three.js (0.187, WebGPURenderer with WebGPU): every pixel looks up in the grid itself, and nothing is resampled.
//
//     scene.add(await NeuralLightGrid.load('level'));    // a folder with grid.bin and look_up.wgsl
//
// Every lit material of the scene has its light from then on: indirect irradiance, beside that of the scene's other lights. look_up.wgsl
// is made of look_up.glsl by export/shader/wgsl.mjs. The WebGL that WebGPURenderer falls back to reads no WGSL:
// the console says so, and nothing is lit.
import { AnalyticLightNode, Light, NodeUpdateType, StorageBufferAttribute, Vector3 } from 'three/webgpu';
import { negateOnBackSide, normalWorld, normalWorldGeometry, positionWorld, renderGroup, storage, uniform, wgsl, wgslFn } from 'three/tsl';

// Of look_up.wgsl: the grid, which three.js declares and binds here.
const DECLARED = /struct NlgGrid \{[^}]*\}\s*@group\(0\) @binding\(0\)\s*var<storage, read> nlg_grid: NlgGrid;/;

async function read(url, form) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response[form]();
}

class NeuralLightGridNode extends AnalyticLightNode {
  static get type() {
    return 'NeuralLightGridNode';
  }

  constructor(grid) {
    super(grid);
    this.updateType = NodeUpdateType.RENDER;
    this.position = uniform(new Vector3()).setGroup(renderGroup);
    this.offset_m = uniform(0).setGroup(renderGroup);
    this.intensity = uniform(0).setGroup(renderGroup);
  }

  update() {
    this.position.value.setFromMatrixPosition(this.light.matrixWorld);
    this.offset_m.value = this.light.offset_m;
    this.intensity.value = this.light.intensity;
  }

  setup(builder) {
    if (!builder.renderer.backend.isWebGPUBackend) throw new Error('three_light_grid_webgpu.js: no WebGPU; use WebGLRenderer and three_light_grid.js');
    // normals by which faces lie, towards the camera: flat ones are so already
    const before = builder.isFlatShading() ? normalWorldGeometry : negateOnBackSide(normalWorldGeometry);
    const place = positionWorld.add(before.mul(this.offset_m)).sub(this.position);
    builder.context.irradiance.addAssign(this.light.irradianceAt(place, normalWorld).mul(this.intensity));
  }
}

export class NeuralLightGrid extends Light {
  #words;

  // folder   its URL; with grid.bin and look_up.wgsl
  // throws   Error where one of the two files is not there, or look_up.wgsl is no such text
  static async load(folder) {
    const [bytes, lookUp] = await Promise.all([read(`${folder}/grid.bin`, 'arrayBuffer'), read(`${folder}/look_up.wgsl`, 'text')]);
    return new NeuralLightGrid(new Uint32Array(bytes), lookUp);
  }

  // words    Uint32Array, grid.bin
  // lookUp   the text of look_up.wgsl
  constructor(words, lookUp) {
    super(0xffffff, 1);
    this.type = 'NeuralLightGrid';
    this.offset_m = 0.02; // so far before a surface its light is looked up, metres
    if (!DECLARED.test(lookUp)) throw new Error('look_up.wgsl: not what export/shader/wgsl.mjs writes');
    // names of its own: a scene may hold several grids
    const own = (text) => text.replace(/\b(nlg|Nlg)/g, `$1${this.id}`);
    this.#words = new StorageBufferAttribute(words, 4);
    const fours = storage(this.#words, 'uvec4', words.length / 4).toReadOnly().setName(own('nlg_grid'));
    const functions = wgsl(own(lookUp.replace(DECLARED, '').replaceAll('nlg_grid.fours', 'nlg_grid.value')));
    const call = 'fn nlgIrradianceAt(position_m: vec3<f32>, normal: vec3<f32>) -> vec3<f32> { var place = position_m; var facing = normal; return nlgIrradiance(&place, &facing).irradiance; }';
    // irradiance of the grid at a place in its level (metres), on a plane that faces the normal: nodes of vec3
    this.irradianceAt = wgslFn(own(call), [fours, functions]);
  }

  // The graphics card's memory is free; the grid is to be in no scene by then.
  dispose() {
    super.dispose();
    this.#words.dispose();
  }
}

NeuralLightGrid.registerNode(NeuralLightGridNode);
