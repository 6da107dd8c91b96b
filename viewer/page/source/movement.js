// The camera: walking with gravity and walls, flying through everything, by keys, mouse and touch.
import * as THREE from 'three';
import { Octree } from 'three/examples/jsm/math/Octree.js';
import { Capsule } from 'three/examples/jsm/math/Capsule.js';

const EYE_M = 1.62, RADIUS_M = 0.3;
const WALK = 3.2, RUN = 2.5, FLY = 6, JUMP = 4.6, GRAVITY = 12; // m/s, a factor, m/s, m/s, m/s²
const LONGEST_STEP_S = 0.02;
const TURN_KEYS = 1.8, TURN_MOUSE = 0.0032, TURN_TOUCH = 0.005; // radians a second; a pixel; a pixel
const STEEPEST = 1.5;
const KEYS = {
  KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0],
};
const TURNS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Movement {
  // canvas   has the focus while keys move the camera
  constructor(camera, canvas) {
    this.camera = camera;
    this.canvas = canvas;
    this.isFlying = false;
    this.isHeld = true; // at a place that was gone to, until keys or a thumb leave it
    this.yaw = this.pitch = 0;
    this.velocity = new THREE.Vector3();
    this.isOnFloor = false;
    this.pressed = new Set();
    this.stick = new THREE.Vector2();
    this.pointers = new Map(); // those that are down
    this.onChange = () => {};
    this.listen();
  }

  lookFrom(eye, forward, fovDegrees) {
    this.camera.position.copy(eye);
    this.yaw = Math.atan2(-forward.x, -forward.z);
    this.pitch = Math.asin(THREE.MathUtils.clamp(forward.y, -1, 1));
    this.camera.fov = fovDegrees;
    this.camera.updateProjectionMatrix();
    this.velocity.set(0, 0, 0);
    this.isHeld = true;
    this.turn();
  }

  press(key) {
    this.pressed.add(key);
    this.onChange();
  }
  release(key) {
    this.pressed.delete(key);
  }

  turn() {
    this.pitch = THREE.MathUtils.clamp(this.pitch, -STEEPEST, STEEPEST);
    this.camera.rotation.set(this.pitch, this.yaw, 0, 'YXZ');
    this.camera.updateMatrixWorld();
  }

  // geometry   of what is walked on
  enter(geometry, bounds) {
    this.geometry = geometry;
    this.bounds = bounds;
    this.octree = null;
  }

  setFlying(isFlying) {
    this.isFlying = isFlying;
    this.velocity.set(0, 0, 0);
  }

  get isMoving() {
    const isFalling = !this.isFlying && !this.isOnFloor && !this.isHeld;
    return this.pressed.size > 0 || this.stick.lengthSq() > 0 || isFalling || this.velocity.lengthSq() > 1e-4;
  }

  // Made when it is first walked: large levels take a second.
  get walls() {
    if (!this.octree) this.octree = new Octree().fromGraphNode(new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial()));
    return this.octree;
  }

  // How far down the floor is; none within 50 m: null.
  floorBelow(from) {
    const hit = this.walls.rayIntersect(new THREE.Ray(from.clone(), new THREE.Vector3(0, -1, 0)));
    return hit && hit.distance < 50 ? hit.distance : null;
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (!(event.code in KEYS) && !(event.code in TURNS) && !['Space', 'ShiftLeft', 'ShiftRight'].includes(event.code)) return;
      if (!event.code.startsWith('Shift')) this.pressed.add(event.code);
      event.preventDefault();
      this.onChange();
    });
    canvas.addEventListener('keyup', (event) => this.pressed.delete(event.code));
    canvas.addEventListener('blur', () => this.pressed.clear());
    window.addEventListener('keydown', (event) => (this.isRunning = event.shiftKey));
    window.addEventListener('keyup', (event) => (this.isRunning = event.shiftKey));

    canvas.addEventListener('pointerdown', (event) => {
      canvas.focus();
      canvas.setPointerCapture(event.pointerId);
      // a thumb on the left half walks, everything else looks
      const walks = event.pointerType === 'touch' && event.clientX < window.innerWidth / 2;
      this.pointers.set(event.pointerId, { walks, x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener('pointermove', (event) => {
      const pointer = this.pointers.get(event.pointerId);
      if (!pointer) return;
      const dx = event.clientX - pointer.x, dy = event.clientY - pointer.y;
      if (pointer.walks) {
        this.stick.set(dx, -dy).divideScalar(60).clampLength(0, 1);
      } else {
        const rate = event.pointerType === 'touch' ? TURN_TOUCH : TURN_MOUSE;
        this.yaw += rate * dx;
        this.pitch += rate * dy;
        pointer.x = event.clientX;
        pointer.y = event.clientY;
        this.turn();
        this.hasTurned = true;
      }
      this.onChange();
    });
    for (const end of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(end, (event) => {
        const pointer = this.pointers.get(event.pointerId);
        this.pointers.delete(event.pointerId);
        if (pointer?.walks && ![...this.pointers.values()].some((other) => other.walks)) this.stick.set(0, 0);
      });
    }
  }

  // The way that keys and thumb ask for: right, up, ahead.
  wish() {
    const wish = new THREE.Vector3(this.stick.x, 0, this.stick.y);
    for (const key of this.pressed) if (key in KEYS) wish.add(new THREE.Vector3(...KEYS[key]));
    return wish.clampLength(0, 1).multiplyScalar(this.isRunning ? RUN : 1);
  }

  // Returns whether the camera moved.
  step(seconds) {
    const before = this.camera.position.clone(), yaw = this.yaw, pitch = this.pitch;
    const wasTurned = this.hasTurned;
    this.hasTurned = false;
    for (const key of this.pressed) {
      if (!(key in TURNS)) continue;
      this.yaw += TURNS[key][0] * TURN_KEYS * seconds;
      this.pitch += TURNS[key][1] * TURN_KEYS * seconds;
    }
    if (this.stick.lengthSq() > 0 || [...this.pressed].some((key) => !(key in TURNS))) this.isHeld = false;
    if (this.isHeld) {
      this.turn();
      return wasTurned || yaw !== this.yaw || pitch !== this.pitch;
    }
    for (let left = seconds; left > 0; left -= LONGEST_STEP_S) {
      if (this.isFlying) this.fly(Math.min(left, LONGEST_STEP_S));
      else this.walk(Math.min(left, LONGEST_STEP_S));
    }
    this.turn();
    return wasTurned || !before.equals(this.camera.position) || yaw !== this.yaw || pitch !== this.pitch;
  }

  fly(seconds) {
    const wish = this.wish();
    if (this.pressed.has('Space')) wish.y += 1;
    const way = new THREE.Vector3(wish.x, 0, -wish.z).applyQuaternion(this.camera.quaternion);
    way.y += wish.y;
    this.camera.position.addScaledVector(way, FLY * seconds);
  }

  walk(seconds) {
    const wish = this.wish();
    const way = new THREE.Vector3(wish.x, 0, -wish.z).applyAxisAngle(new THREE.Vector3(0, 1, 0), this.yaw).multiplyScalar(WALK);
    this.velocity.x = way.x;
    this.velocity.z = way.z;
    if (this.isOnFloor && this.pressed.has('Space')) {
      this.velocity.y = JUMP;
      this.isOnFloor = false;
    }
    this.velocity.y -= GRAVITY * seconds;
    const eye = this.camera.position;
    eye.addScaledVector(this.velocity, seconds);
    const body = new Capsule(new THREE.Vector3(eye.x, eye.y - EYE_M + RADIUS_M, eye.z), eye.clone(), RADIUS_M);
    const hit = this.walls.capsuleIntersect(body);
    this.isOnFloor = false;
    if (hit) {
      this.isOnFloor = hit.normal.y > 0.5;
      if (this.isOnFloor) this.velocity.y = 0;
      else this.velocity.addScaledVector(hit.normal, -Math.min(0, hit.normal.dot(this.velocity)));
      // a hair stays, so that who stands keeps touching the floor
      eye.addScaledVector(hit.normal, Math.max(0, hit.depth - 1e-4));
    }
    // out of the level: in again at its top
    if (eye.y < this.bounds.min.y - 20) {
      this.velocity.set(0, 0, 0);
      this.bounds.getCenter(eye);
      eye.y = this.bounds.max.y;
    }
  }
}
