// From two methods to the screen: each is drawn in radiance, then both are shown side by side or as their difference.
import * as THREE from 'three';
import pictureVertex from './glsl/picture.vert.glsl';
import pictureFragment from './glsl/picture.frag.glsl';
import signedHeat from './glsl/signed_heat.glsl';
import neutralTone from '../../../render/neutral_tone.glsl';
import { PRECISION } from './methods.js';

export class Picture {
  constructor(renderer) {
    this.renderer = renderer;
    // of a side of which nothing is known
    this.nothing = new THREE.DataTexture(new Uint8Array([48, 48, 48, 0]), 1, 1);
    this.nothing.needsUpdate = true;
    this.targets = [0, 1].map(() => new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType, samples: 4 }));
    this.material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: pictureVertex,
      fragmentShader: PRECISION + signedHeat + neutralTone + pictureFragment,
      depthTest: false,
      depthWrite: false,
      uniforms: {
        left: { value: null },
        right: { value: null },
        left_scale: { value: new THREE.Vector2() },
        right_scale: { value: new THREE.Vector2() },
        units: { value: new THREE.Vector2(1, 1) },
        divider: { value: 0.5 },
        exposure: { value: 1 },
        texel: { value: 0 },
        is_difference: { value: false },
      },
    });
    const triangle = new THREE.BufferGeometry();
    triangle.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    this.scene = new THREE.Scene();
    const mesh = new THREE.Mesh(triangle, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    this.camera = new THREE.Camera();
  }

  // window_width   in the units of the page: the divider is as thin at every sharpness
  resize(width, height, window_width) {
    for (const target of this.targets) target.setSize(width, height);
    this.width = width;
    this.height = height;
    this.material.uniforms.texel.value = 1 / window_width;
  }

  // sides      left and right: {draw} renders into the target that is set, {truth} is a stored picture; null: nothing is known
  // divider    share of the width that the left one has
  show(sides, divider, exposure, isDifference) {
    const { renderer } = this;
    const uniforms = this.material.uniforms;
    const border = Math.round(divider * this.width);
    sides.forEach((side, i) => {
      const name = ['left', 'right'][i];
      const scale = uniforms[`${name}_scale`].value;
      if (side?.truth) {
        uniforms[name].value = side.truth.texture;
        scale.set(this.width / this.height / side.truth.aspect, 1);
        uniforms.units.value.setComponent(i, side.truth.unit);
        return;
      }
      const target = this.targets[i];
      uniforms[name].value = target.texture;
      scale.set(0, 0);
      const first = i === 0 || isDifference ? 0 : border, end = i === 1 || isDifference ? this.width : border;
      if (!side) uniforms[name].value = this.nothing;
      if (!side || end <= first) return;
      // a pixel beyond the border, so that its edge is as smooth as all others
      target.scissorTest = true;
      target.scissor.set(Math.max(0, first - 1), 0, end - first + 2, this.height);
      renderer.setRenderTarget(target);
      renderer.clear();
      side.draw();
    });
    uniforms.divider.value = isDifference ? 1 : divider;
    uniforms.exposure.value = exposure;
    uniforms.is_difference.value = isDifference;
    renderer.setRenderTarget(null);
    renderer.render(this.scene, this.camera);
  }
}
