// What stands in the level: its triangles, its sky, and what the viewer carries along.
import * as THREE from 'three';
import surfaceVertex from './glsl/surface.vert.glsl';
import depthFragment from './glsl/depth.frag.glsl';
import skyFragment from './glsl/sky.frag.glsl';
import { PRECISION } from './methods.js';

const CARRIED_ALBEDO = 0.3; // nlg-render's balls have the same

// Where each corner lies on its images, and what of a transmissive surface is seen: attributes of looks.glsl. Scenes without images have none.
function addLooks(scene, geometry) {
  if (!scene.images_of) return;
  const count = scene.triangle_material.length;
  const base = new Float32Array(12 * count), shine = new Float32Array(12 * count), transmissive = new Float32Array(6 * count);
  const albedo = geometry.attributes.albedo.array;
  const place = (places, vertex, at) => (places.length > 0 ? places[2 * vertex + at] : 0);
  for (let t = 0; t < count; ++t) {
    const look = scene.material_looks.subarray(5 * scene.triangle_material[t], 5 * scene.triangle_material[t] + 5);
    for (let k = 0; k < 3; ++k) {
      const corner = 3 * t + k, vertex = scene.triangles[corner];
      base.set([place(scene.base_places, vertex, 0), place(scene.base_places, vertex, 1), look[0], look[1]], 4 * corner);
      shine.set([place(scene.emissive_places, vertex, 0), place(scene.emissive_places, vertex, 1), look[2], look[3]], 4 * corner);
      const colour = scene.vertex_colours.length > 0 ? scene.vertex_colours.subarray(4 * vertex, 4 * vertex + 4) : [1, 1, 1, 1];
      for (let c = 0; c < 3; ++c) albedo[3 * corner + c] *= colour[c];
      transmissive.set([colour[3], look[4]], 2 * corner);
    }
  }
  geometry.setAttribute('base_at', new THREE.BufferAttribute(base, 4));
  geometry.setAttribute('shine_at', new THREE.BufferAttribute(shine, 4));
  geometry.setAttribute('transmissive_share', new THREE.BufferAttribute(transmissive, 2));
}

// Triangles with corners of their own: flat normals, and the colours of their materials.
function levelGeometry(scene) {
  const count = scene.triangle_material.length;
  const positions = new Float32Array(9 * count), normals = new Float32Array(9 * count);
  const albedo = new Float32Array(9 * count), shine = new Float32Array(9 * count);
  const a = new THREE.Vector3(), b = new THREE.Vector3(), c = new THREE.Vector3();
  for (let t = 0; t < count; ++t) {
    [a, b, c].forEach((corner, k) => corner.fromArray(scene.positions, 3 * scene.triangles[3 * t + k]).toArray(positions, 9 * t + 3 * k));
    b.sub(a).cross(c.sub(a)).normalize();
    const material = 3 * scene.triangle_material[t];
    for (let k = 0; k < 3; ++k) {
      b.toArray(normals, 9 * t + 3 * k);
      albedo.set(scene.albedo.subarray(material, material + 3), 9 * t + 3 * k);
      shine.set(scene.emissive_0.subarray(material, material + 3), 9 * t + 3 * k);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
  geometry.setAttribute('albedo', new THREE.BufferAttribute(albedo, 3));
  geometry.setAttribute('shine', new THREE.BufferAttribute(shine, 3));
  addLooks(scene, geometry);
  return geometry;
}

function evenColours(geometry, albedo) {
  const plain = geometry.index ? geometry.toNonIndexed() : geometry;
  const count = plain.attributes.position.count;
  plain.setAttribute('albedo', new THREE.BufferAttribute(new Float32Array(3 * count).fill(albedo), 3));
  plain.setAttribute('shine', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  const noTransmissive = new Float32Array(2 * count).fill(-1);
  plain.setAttribute('transmissive_share', new THREE.BufferAttribute(noTransmissive, 2));
  for (const name of ['base_at', 'shine_at']) plain.setAttribute(name, new THREE.BufferAttribute(new Float32Array(4 * count), 4));
  return plain;
}

function skyMaterial(side) {
  const vector = () => ({ value: new THREE.Vector3() });
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: surfaceVertex,
    fragmentShader: skyFragment,
    uniforms: { zenith: vector(), horizon: vector(), ground: vector() },
    side,
  });
}

// A person of 1.75 m, from simple shapes, the feet at the origin.
function figureParts() {
  const parts = [];
  const add = (geometry, x, y, z, turn = 0) => parts.push(geometry.rotateZ(turn).translate(x, y, z));
  add(new THREE.SphereGeometry(0.12, 24, 16), 0, 1.62, 0);
  add(new THREE.CapsuleGeometry(0.17, 0.36, 8, 20), 0, 1.16, 0);
  add(new THREE.SphereGeometry(0.16, 20, 12), 0, 0.88, 0);
  for (const side of [-1, 1]) {
    add(new THREE.CapsuleGeometry(0.055, 0.5, 6, 12), side * 0.27, 1.1, 0, side * 0.16);
    add(new THREE.CapsuleGeometry(0.08, 0.66, 6, 12), side * 0.1, 0.44, 0, side * 0.03);
  }
  return parts;
}

export class Level {
  // looks   of looksOf
  constructor(scene, looks) {
    this.scene = scene;
    this.root = new THREE.Scene();
    this.root.matrixWorldAutoUpdate = false;
    this.geometry = levelGeometry(scene);
    this.geometry.computeBoundingBox();
    this.bounds = this.geometry.boundingBox;

    // depth first: a surface that is hidden asks for no light
    const depth = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: looks.vertex + surfaceVertex,
      fragmentShader: PRECISION + looks.fragment + depthFragment,
      uniforms: looks.uniforms,
      side: THREE.DoubleSide,
      colorWrite: false,
    });
    this.add(new THREE.Mesh(this.geometry, depth), 0);
    this.surfaces = this.add(new THREE.Mesh(this.geometry, depth), 1);

    const dome = evenColours(new THREE.BoxGeometry(2, 2, 2), 0);
    dome.attributes.shine.array.fill(-1);
    this.dome = this.add(new THREE.Mesh(dome, skyMaterial(THREE.BackSide)), -1);
    this.dome.material.depthWrite = false;
    this.skies = [this.dome];
    if (scene.sky_positions.length > 0) this.addSkyFaces(scene);
    this.tintSky(() => [1, 1, 1]);

    this.ball = this.add(new THREE.Mesh(evenColours(new THREE.SphereGeometry(0.15, 48, 32), CARRIED_ALBEDO), depth), 2);
    this.figure = this.add(new THREE.Group(), 2);
    for (const part of figureParts()) {
      const mesh = new THREE.Mesh(evenColours(part, CARRIED_ALBEDO), depth);
      mesh.frustumCulled = false;
      mesh.renderOrder = 2;
      this.figure.add(mesh);
    }
    this.ball.visible = this.figure.visible = false;
    this.ballAt = new THREE.Vector4(0, 0, 0, 1);
    this.materials = new Map();
  }

  // What shines, in the colours of its groups of light: the sum of all light states.
  // colourOf   three factors by a group's name
  tintShine(colourOf) {
    const { scene } = this;
    if (scene.light_groups.length === 0) return;
    const { shine } = this.geometry.attributes;
    const tints = scene.light_groups.map(colourOf);
    shine.array.fill(0);
    scene.skies.forEach((_, set) => {
      const emissive = scene[`emissive_${set}`], groups = scene[`emissive_groups_${set}`];
      (scene[`triangle_material_${set}`] ?? scene.triangle_material).forEach((material, t) => {
        const tint = tints[groups[material]];
        for (let i = 0; i < 9; ++i) shine.array[9 * t + i] += emissive[3 * material + (i % 3)] * tint[i % 3];
      });
    });
    shine.needsUpdate = true;
  }

  // What the graphics card holds of it.
  dispose() {
    this.root.traverse(({ geometry, material }) => {
      geometry?.dispose();
      material?.dispose();
    });
    for (const materials of this.materials.values()) for (const material of Object.values(materials)) material.dispose();
  }

  tintSky(colourOf) {
    for (const part of ['zenith', 'horizon', 'ground']) {
      const sum = [0, 1, 2].map((c) => this.scene.skies.reduce((all, sky) => all + sky[part][c] * colourOf(sky.group)[c], 0));
      for (const { material } of this.skies) material.uniforms[part].value.set(...sum);
    }
  }

  add(object, order) {
    object.renderOrder = order;
    object.frustumCulled = false;
    this.root.add(object);
    return object;
  }

  addSkyFaces(scene) {
    const geometry = new THREE.BufferGeometry();
    const corners = scene.sky_positions.length / 3;
    const shine = new Float32Array(3 * corners);
    for (let i = 0; i < corners; ++i) shine.set(scene.sky_shine.subarray(3 * Math.floor(i / 3), 3 * Math.floor(i / 3) + 3), 3 * i);
    geometry.setAttribute('position', new THREE.BufferAttribute(scene.sky_positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
    geometry.setAttribute('albedo', new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
    geometry.setAttribute('shine', new THREE.BufferAttribute(shine, 3));
    this.skies.push(this.add(new THREE.Mesh(geometry, skyMaterial(THREE.FrontSide)), 1));
  }

  place(ball, figure) {
    this.ball.position.copy(ball);
    this.ballAt.set(ball.x, ball.y, ball.z, 1);
    this.figure.position.copy(figure.feet);
    this.figure.rotation.y = figure.turn;
  }

  // All that is drawn is lit by this method from now on, or shows something else of it (RenderedMethod).
  lightBy(method, shown) {
    const key = `${method.name} ${shown}`;
    if (!this.materials.has(key)) {
      this.materials.set(key, {
        surface: method.material(shown, THREE.DoubleSide),
        ball: method.material(shown, THREE.FrontSide, this.ballAt),
        figure: method.material(shown, THREE.FrontSide),
      });
    }
    const { surface, ball, figure } = this.materials.get(key);
    this.surfaces.material = surface;
    this.ball.material = ball;
    for (const part of this.figure.children) part.material = figure;
  }
}
