// What is drawn over the level: probes by kind, the tree's cells, the worst place.
import * as THREE from 'three';
import markVertex from './glsl/mark.vert.glsl';
import markFragment from './glsl/mark.frag.glsl';

// In the order of ProbeKind (viewer/data_script.h); told apart without red against green.
export const KINDS = [
  { title: 'function', colour: [0.9, 0.6, 0.0] },
  { title: 'bare tent', colour: [0.35, 0.7, 0.9] },
  { title: 'function, in solid', colour: [0.8, 0.3, 0.65] },
  { title: 'empty', colour: [0.35, 0.35, 0.35] },
];
const PROBE_M = 0.06, PROBE_REACH_M = 14, CELL_REACH_M = 7;

function markMaterial(reach_m, opacity, isSmall = false) {
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: markVertex,
    fragmentShader: markFragment,
    uniforms: { reach_m: { value: reach_m }, opacity: { value: opacity }, is_small: { value: isSmall } },
  });
}

function instanced(shape, marks, tints, material, Kind = THREE.Mesh) {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute('position', shape.attributes.position);
  geometry.setIndex(shape.index);
  geometry.setAttribute('mark', new THREE.InstancedBufferAttribute(marks, 4));
  geometry.setAttribute('tint', new THREE.InstancedBufferAttribute(tints, 3));
  geometry.instanceCount = marks.length / 4;
  const object = new Kind(geometry, material);
  object.frustumCulled = false;
  object.renderOrder = 3;
  return object;
}

export class Marks {
  constructor(root, data) {
    this.root = root;
    this.source = data;
  }

  // Reads them the first time.
  async probes() {
    if (!this.data) {
      this.data = await this.source.load('probes');
      const count = this.data.kinds.length;
      const marks = new Float32Array(4 * count), tints = new Float32Array(3 * count);
      for (let i = 0; i < count; ++i) {
        marks.set(this.data.positions.subarray(3 * i, 3 * i + 3), 4 * i);
        marks[4 * i + 3] = PROBE_M;
        tints.set(KINDS[this.data.kinds[i]].colour, 3 * i);
      }
      this.probeMarks = instanced(new THREE.OctahedronGeometry(1, 1), marks, tints, markMaterial(PROBE_REACH_M, 1, true));
      const cells = this.data.cells.length / 4;
      const corners = new Float32Array(this.data.cells);
      const unit = new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1).translate(0.5, 0.5, 0.5));
      this.cellMarks = instanced(unit, corners, new Float32Array(3 * cells).fill(0.8), markMaterial(CELL_REACH_M, 0.8), THREE.LineSegments);
      this.probeMarks.visible = this.cellMarks.visible = false;
      this.root.add(this.probeMarks, this.cellMarks);
    }
    return this.data;
  }

  // The probe nearest to a place, among those that have weight somewhere; none: -1.
  async nearestTo(place) {
    const { positions, records } = await this.probes();
    const best = { probe: -1, distance: Infinity };
    for (let i = 0; i < records.length; ++i) {
      if (records[i] === 0) continue;
      const distance = Math.hypot(positions[3 * i] - place.x, positions[3 * i + 1] - place.y, positions[3 * i + 2] - place.z);
      if (distance < best.distance) Object.assign(best, { probe: i, distance });
    }
    return best.probe;
  }

  choose(probe) {
    if (this.ring) this.root.remove(this.ring);
    this.ring = instanced(new THREE.OctahedronGeometry(1, 2), new Float32Array([...this.data.positions.subarray(3 * probe, 3 * probe + 3), 2 * PROBE_M]),
      new Float32Array([1, 1, 1]), markMaterial(100, 1));
    this.root.add(this.ring);
  }

  // A ball's needle at the place where a method was measured.
  showPlace(place, normal) {
    if (this.needle) this.root.remove(this.needle);
    this.needle = null;
    if (!place) return;
    const count = 24, marks = new Float32Array(4 * count);
    for (let i = 0; i < count; ++i) {
      marks.set([0, 1, 2].map((axis) => place[axis] + normal[axis] * (0.1 + 0.01 * i)), 4 * i);
      marks[4 * i + 3] = 0.008;
    }
    this.needle = instanced(new THREE.OctahedronGeometry(1, 0), marks, new Float32Array(3 * count).fill(1), markMaterial(100, 1));
    this.root.add(this.needle);
  }
}
