// Small white patches, drawn one after the other, a pixel each: what three.js makes of the light at a list of places.
// The page defines kPlaces (three_cases.cpp).

const kPixelsARow = 64, kHalfPatch = 0.005, kHalfPixel = 0.001, kEye = 0.05;  // metres

export class Patches {
  // origin   of the level, in the world
  constructor(THREE, {origin = [0, 0, 0]} = {}) {
    this.THREE = THREE;
    this.origin = new THREE.Vector3(...origin);
    const quad = new THREE.PlaneGeometry(2 * kHalfPatch, 2 * kHalfPatch);
    const skinned = quad.clone();
    skinned.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(new Uint16Array(16), 4));
    skinned.setAttribute('skinWeight', new THREE.Float32BufferAttribute([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], 4));
    const bone = new THREE.Bone(), skeletonMesh = new THREE.SkinnedMesh(skinned, new THREE.MeshToonMaterial());
    skeletonMesh.add(bone);
    skeletonMesh.bind(new THREE.Skeleton([bone]));
    const instances = new THREE.InstancedMesh(quad, new THREE.MeshPhongMaterial({specular: 0}), 2);
    // squeezed along its normal: not what the normal is transformed by
    const group = new THREE.Group();
    group.scale.set(1, 1, 0.5);
    group.add(new THREE.Mesh(quad, new THREE.MeshLambertMaterial()));
    const behind = new THREE.Mesh(quad, new THREE.MeshPhysicalMaterial({specularIntensity: 0, side: THREE.DoubleSide}));
    // what stands at a place, and what moves it there; the last shows its back
    this.kinds = [
      {root: group, moveTo: (at, turn) => (group.position.copy(at), group.quaternion.copy(turn))},
      {root: instances, moveTo: (at, turn) => {
        instances.setMatrixAt(1, new THREE.Matrix4().compose(at, turn, new THREE.Vector3(1, 1, 1)));
        instances.instanceMatrix.needsUpdate = true;
      }},
      {root: skeletonMesh, moveTo: (at, turn) => (bone.position.copy(at), bone.quaternion.copy(turn))},
      {root: behind, moveTo: (at, turn) => (behind.position.copy(at), behind.quaternion.copy(turn).multiply(new THREE.Quaternion(0, 1, 0, 0)))},
    ];
    for (const {root} of this.kinds) root.traverse((object) => (object.frustumCulled = false));
  }

  get objects() {
    return this.kinds.map((kind) => kind.root);
  }

  // Radiance times pi, four numbers a place; the fourth is 1 where a patch was drawn.
  async draw(renderer, scene) {
    const {THREE} = this, rows = Math.ceil(kPlaces.length / kPixelsARow);
    const Target = renderer.isWebGLRenderer ? THREE.WebGLRenderTarget : THREE.RenderTarget;
    const target = new Target(kPixelsARow, rows, {type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter});
    const camera = new THREE.OrthographicCamera(-kHalfPixel, kHalfPixel, kHalfPixel, -kHalfPixel, 0.5 * kEye, 2 * kEye);
    renderer.setRenderTarget(target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.autoClear = false;
    const at = new THREE.Vector3(), normal = new THREE.Vector3(), turn = new THREE.Quaternion(), z = new THREE.Vector3(0, 0, 1);
    for (const [i, place] of kPlaces.entries()) {
      // WebGPURenderer reads bones once a frame
      if (!renderer.isWebGLRenderer && i % this.kinds.length === 0) await new Promise(requestAnimationFrame);
      at.fromArray(place.position).add(this.origin);
      normal.fromArray(place.normal);
      turn.setFromUnitVectors(z, normal);
      this.kinds.forEach((kind, k) => (kind.root.visible = k === i % this.kinds.length));
      this.kinds[i % this.kinds.length].moveTo(at, turn);
      camera.position.copy(at).addScaledVector(normal, kEye);
      camera.lookAt(at);
      target.viewport.set(i % kPixelsARow, Math.floor(i / kPixelsARow), 1, 1);
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
    }
    let numbers = new Float32Array(4 * kPixelsARow * rows);
    if (renderer.isWebGLRenderer) renderer.readRenderTargetPixels(target, 0, 0, kPixelsARow, rows, numbers);
    else numbers = await renderer.readRenderTargetPixelsAsync(target, 0, 0, kPixelsARow, rows);
    renderer.setRenderTarget(null);
    target.dispose();
    return Array.from(numbers.subarray(0, 4 * kPlaces.length), (number, i) => i % 4 === 3 ? number : Math.PI * number);
  }
}
