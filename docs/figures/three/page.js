// For compare.py, in the browser: three.js bakes its own LightProbeGrid of level.glb; its shader's lines read that grid and light.bin at points.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { LightProbeGridWebGL } from 'three/addons/lighting/LightProbeGridWebGL.js';
import { MeshSurfaceSampler } from 'three/addons/math/MeshSurfaceSampler.js';
import { mergeGeometries } from 'three/addons/utils/BufferGeometryUtils.js';

const kShadowTexels = 2048, kWatt = 683;  // lm: nlg's --light-unit watt
// of sample points, as nlg-export engine has them: metres before surfaces; from lamps, and shares of the level's diagonal
const kNearestM = 0.05, kFurthestM = 0.5, kLampM = 1, kLampShare = 0.04;
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.shadowMap.enabled = true;
const scene = new THREE.Scene();
const box = new THREE.Box3();
let everything, camera, own, ours;

function worldGeometry(mesh, keepsUv) {
  const geometry = mesh.geometry.index ? mesh.geometry.toNonIndexed() : mesh.geometry.clone();
  for (const name of Object.keys(geometry.attributes)) {
    if (!['position', 'normal'].includes(name) && !(name === 'uv' && keepsUv)) geometry.deleteAttribute(name);
  }
  if (!geometry.attributes.normal) geometry.computeVertexNormals();
  return geometry.applyMatrix4(mesh.matrixWorld);
}

// Shadows of a light that reach the whole level.
function castShadows(light) {
  const centre = box.getCenter(new THREE.Vector3()), radius = box.getSize(new THREE.Vector3()).length() / 2;
  light.intensity /= kWatt;
  light.castShadow = true;
  light.shadow.mapSize.set(kShadowTexels, kShadowTexels);
  light.shadow.normalBias = 0.02;
  light.shadow.camera.near = 0.02;
  light.shadow.camera.far = 4 * radius;
  if (!light.isDirectionalLight) return;
  const away = light.getWorldPosition(new THREE.Vector3()).sub(light.target.getWorldPosition(new THREE.Vector3())).normalize();
  scene.add(light, light.target);
  light.target.position.copy(centre);
  light.position.copy(centre).addScaledVector(away, 2 * radius);
  Object.assign(light.shadow.camera, { left: -radius, right: radius, bottom: -radius, top: radius });
}

// One diffuse mesh a material, as our tracer has surfaces.
export async function load(sky) {
  const { scene: level, cameras } = await new GLTFLoader().loadAsync('level.glb');
  level.updateMatrixWorld(true);
  box.setFromObject(level);
  const byMaterial = new Map(), lights = [];
  level.traverse((object) => {
    if (object.isLight) lights.push(object);
    if (object.isMesh) byMaterial.set(object.material, [...(byMaterial.get(object.material) ?? []), object]);
  });
  for (const [material, meshes] of byMaterial) {
    const mesh = new THREE.Mesh(mergeGeometries(meshes.map((one) => worldGeometry(one, material.map))), new THREE.MeshLambertMaterial().copy(material));
    mesh.castShadow = !(material.transparent && material.opacity < 0.5);
    mesh.receiveShadow = true;
    scene.add(mesh);
  }
  everything = new THREE.Mesh(mergeGeometries([...byMaterial.values()].flat().map((mesh) => worldGeometry(mesh, false))), new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }));
  for (const light of lights) {
    if (!light.isDirectionalLight) scene.attach(light);
    castShadows(light);
  }
  scene.background = new THREE.Color(...sky);
  camera = cameras[0] ?? new THREE.PerspectiveCamera(75).translateX(box.getCenter(new THREE.Vector3()).x).translateY(1.6).translateZ(box.getCenter(new THREE.Vector3()).z);
  camera.updateMatrixWorld(true);
}

function direction() {
  return new THREE.Vector3().randomDirection();
}

function firstHit(from, towards, far = Infinity) {
  return new THREE.Raycaster(from, towards, 0, far).intersectObject(everything)[0];
}

// Most of what rays meet from solid are backs. Light beside lamps falls off within less than a texel.
function isFit(place) {
  const lampM = Math.min(kLampM, kLampShare * box.getSize(new THREE.Vector3()).length());
  if (scene.children.some((object) => object.isPointLight && object.position.distanceTo(place) < lampM)) return false;
  let fronts = 0;
  for (let i = 0; i < 5; ++i) {
    const towards = direction(), hit = firstHit(place, towards);
    fronts += !hit || hit.face.normal.dot(towards) < 0;
  }
  return fronts >= 3;
}

// Position and normal: the first half anywhere in the air of the level, the second before surfaces.
export function points(count) {
  const sampler = new MeshSurfaceSampler(everything).build(), found = [];
  while (found.length < count) {
    let place = new THREE.Vector3(), normal = direction();
    if (found.length < count / 2) {
      place.set(Math.random(), Math.random(), Math.random()).multiply(box.getSize(new THREE.Vector3())).add(box.min);
    } else {
      sampler.sample(place, normal);
      if (Math.random() < 0.5) normal.negate();
      const distance = THREE.MathUtils.randFloat(kNearestM, kFurthestM);
      const hit = firstHit(place.clone().addScaledVector(normal, 1e-3), normal, distance);
      place.addScaledVector(normal, distance);
      if (hit || !box.containsPoint(place)) continue;
    }
    if (isFit(place)) found.push([...place, ...normal]);
  }
  return found;
}

function emptyGrid({ low_m, high_m, resolution }) {
  const size = high_m.map((high, axis) => high - low_m[axis]);
  const grid = new LightProbeGridWebGL(...size, ...resolution);
  grid.position.fromArray(low_m.map((low, axis) => low + size[axis] / 2));
  grid.updateBoundingBox();
  return grid;
}

export function bake(place, options) {
  own = emptyGrid(place);
  scene.add(own);
  const start = performance.now();
  own.bake(renderer, scene, options);
  irradiance(own, [[0, 0, 0, 0, 1, 0]]);  // waits for the GPU
  return performance.now() - start;
}

export async function loadOurs(place) {
  ours = emptyGrid(place);
  ours.texture = new THREE.Data3DTexture(new Uint16Array(await (await fetch('light.bin')).arrayBuffer()), ...place.texture_size);
  Object.assign(ours.texture, { type: THREE.HalfFloatType, minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter, needsUpdate: true });
}

function irradiance(grid, places) {
  const table = (first) => {
    const texture = new THREE.DataTexture(new Float32Array(places.flatMap((place) => [...place.slice(first, first + 3), 0])), places.length, 1, THREE.RGBAFormat, THREE.FloatType);
    texture.needsUpdate = true;
    return { value: texture };
  };
  const target = new THREE.WebGLRenderTarget(places.length, 1, { type: THREE.FloatType, depthBuffer: false });
  const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.ShaderMaterial({
    uniforms: {
      positions: table(0), normals: table(3), probesSH: { value: [grid.texture] }, probesMin: { value: [grid.boundingBox.min] },
      probesMax: { value: [grid.boundingBox.max] }, probesResolution: { value: [grid.resolution] },
    },
    vertexShader: 'void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
    fragmentShader: `uniform highp sampler2D positions, normals;
      ${THREE.ShaderChunk.lightprobes_pars_fragment.replaceAll('NUM_LIGHT_PROBE_GRIDS', '1')}
      void main() {
        vec3 at = texelFetch(positions, ivec2(gl_FragCoord), 0).xyz, normal = texelFetch(normals, ivec2(gl_FragCoord), 0).xyz;
        bool inside = isInsideLightProbeGrid(at, normal, probesMin[0], probesMax[0], probesResolution[0]);
        gl_FragColor = inside ? vec4(getLightProbeGridIrradiance(probesSH[0], probesMin[0], probesMax[0], probesResolution[0], at, normal), 1.0) : vec4(0.0);
      }`,
  }));
  quad.frustumCulled = false;
  renderer.setRenderTarget(target);
  renderer.render(new THREE.Scene().add(quad), new THREE.Camera());
  const numbers = new Float32Array(4 * places.length);
  renderer.readRenderTargetPixels(target, 0, 0, places.length, 1, numbers);
  renderer.setRenderTarget(null);
  return places.map((_, i) => Array.from(numbers.subarray(4 * i, 4 * i + 3)));
}

export function read(places) {
  return { own: irradiance(own, places), ours: irradiance(ours, places) };
}

// The level by each grid and three.js's own lights.
export function pictures(exposure) {
  renderer.setSize(640, 400);
  Object.assign(renderer, { toneMapping: THREE.LinearToneMapping, toneMappingExposure: exposure });
  camera.aspect = 640 / 400;
  camera.updateProjectionMatrix();
  return [own, ours].map((grid) => {
    scene.remove(own, ours);
    scene.add(grid);
    renderer.shadowMap.needsUpdate = true;
    renderer.render(scene, camera);
    return renderer.domElement.toDataURL();
  });
}
