// The page of nlg-view.
import * as THREE from 'three';
import { load } from './data.js';
import { Level } from './level.js';
import { KINDS, Marks } from './marks.js';
import { Methods, TRUTH } from './methods.js';
import { Movement } from './movement.js';
import { Picture } from './picture.js';

const root = document.documentElement;
const $ = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search); // a test asks for a view: ?view=0&left=grid&right=ddgi&divider=1&ui=0

// What went wrong, where everybody sees it; tests read it too.
function fail(error) {
  console.error(error);
  root.dataset.error = String(error.message ?? error);
  $('message').textContent = `This page cannot go on: ${error.message ?? error}`;
  $('message').hidden = false;
}

const bytesText = (bytes) => (bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.round(bytes / 1e3)} kB`);

class Viewer {
  constructor(scene) {
    this.scene = scene;
    const canvas = $('canvas');
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    if (!this.renderer.extensions.has('EXT_color_buffer_float') && !this.renderer.extensions.has('EXT_color_buffer_half_float')) {
      throw new Error('this browser draws no pictures in half floats (EXT_color_buffer_half_float)');
    }
    this.picture = new Picture(this.renderer);
    this.methods = new Methods(scene);
    this.level = new Level(scene);
    this.marks = new Marks(this.level.root);
    // near enough for views that were chosen millimetres before a wall
    const reach = 2 * this.level.bounds.getSize(new THREE.Vector3()).length();
    this.camera = new THREE.PerspectiveCamera(60, 1, 0.004, Math.max(10, reach));
    this.movement = new Movement(this.camera, canvas, this.level.geometry, this.level.bounds);
    this.movement.onChange = () => this.wake();
    this.truth = [null, null];
    this.left = 'grid';
    this.right = null;
    this.shown = 'light';
    this.chosen = -1;
    this.places = [
      ...scene.views.map((view, i) => ({ ...view, group: 'views with ground truth', truth: i })),
      ...scene.starts.map((start) => ({ ...start, group: 'where players begin' })),
      ...scene.worst.map((worst) => ({ ...worst, group: 'where the grid is most wrong' })),
    ];
    this.at = null; // the place that the camera stands at, until it moves
    this.frames = [];
  }

  async start() {
    this.fillInterface();
    await this.choose('left', asked.get('left') ?? 'grid');
    const right = asked.get('right') ?? (this.methods.has('valid-trilinear') ? 'valid-trilinear' : this.scene.methods.at(-1).name);
    await this.choose('right', right);
    $('divider').value = asked.has('divider') ? 100 * Number(asked.get('divider')) : 50;
    if (asked.has('exposure')) this.exposure = Number(asked.get('exposure'));
    if (asked.get('ui') === '0') document.body.classList.add('bare');
    for (const mark of ['probes', 'cells', 'ball', 'figure']) {
      if (asked.get(mark) === '1') $(mark).checked = true;
    }
    await this.toggle();
    await this.goTo(Number(asked.get('place') ?? 0));
    if (asked.has('show')) await this.show(asked.get('show'));
    this.resize();
    new ResizeObserver(() => this.resize()).observe($('canvas'));
    this.draw();
    root.dataset.firstFrameMs = Math.round(performance.now());
    root.dataset.ready = '1';
  }

  get divider() {
    return Number($('divider').value) / 100;
  }

  // ---- what is shown

  async choose(side, name) {
    if (!this.methods.has(name)) throw new Error(`no method ${name}; there are ${[TRUTH, ...this.methods.entries.keys()].join(', ')}`);
    this[side] = name;
    $(side).value = name;
    if (name !== TRUTH) await this.busy(this.methods.rendered(name));
    await this.readTruth();
    this.wake();
  }

  // A stored picture is right for one camera only.
  async readTruth() {
    const view = this.at?.truth;
    for (const [i, side] of ['left', 'right'].entries()) {
      this.truth[i] = this[side] === TRUTH && view !== undefined ? await this.busy(this.methods.truth(view)) : null;
    }
    const missing = [this.left, this.right].includes(TRUTH) && view === undefined;
    $('hint').textContent = missing ? 'Ground truth is stored of views: choose one under “go to”.' : '';
  }

  async busy(promise) {
    root.classList.add('busy');
    try {
      return await promise;
    } finally {
      root.classList.remove('busy');
    }
  }

  async show(what) {
    $('show').value = this.shown = what;
    if (what === 'share' && this.chosen < 0) await this.chooseProbe();
    this.wake();
  }

  // The probe nearest to what stands in the middle of the picture.
  async chooseProbe() {
    const ray = new THREE.Ray(this.camera.position.clone(), this.camera.getWorldDirection(new THREE.Vector3()));
    const hit = this.movement.walls.rayIntersect(ray);
    const probe = await this.busy(this.marks.nearestTo(hit ? hit.position : ray.at(2, new THREE.Vector3())));
    if (probe < 0) return;
    this.chosen = probe;
    this.marks.choose(probe);
    const kind = KINDS[this.marks.data.kinds[probe]].title;
    $('probe').textContent = `probe ${probe}: ${kind}`;
    this.wake();
  }

  async toggle() {
    if ($('probes').checked || $('cells').checked) await this.busy(this.marks.probes());
    if (this.marks.probeMarks) {
      this.marks.probeMarks.visible = $('probes').checked;
      this.marks.cellMarks.visible = $('cells').checked;
    }
    this.fillLegend();
    this.level.ball.visible = $('ball').checked;
    this.level.figure.visible = $('figure').checked;
    this.wake();
  }

  // ---- from where

  async goTo(index) {
    const place = this.places[index];
    if (!place) throw new Error(`no place ${index}; there are ${this.places.length}`);
    this.movement.lookFrom(new THREE.Vector3(...place.eye), new THREE.Vector3(...place.forward), THREE.MathUtils.radToDeg(place.fov_y));
    this.at = place;
    $('place').value = index;
    this.marks.showPlace(place.place, place.normal);
    $('placeNote').textContent = place.error === undefined ? '' : `error ${place.error.toFixed(2)} of truth's root mean square`;
    if (place.place) this.hang(new THREE.Vector3(...place.place));
    else this.hung = null;
    await this.readTruth();
    this.wake();
  }

  // A ball at a place, whether or not one is carried.
  hang(place) {
    this.hung = place;
  }

  left_() {
    if (!this.at) return;
    this.at = null;
    $('placeNote').textContent = '';
    this.readTruth();
  }

  carry() {
    const ahead = this.camera.getWorldDirection(new THREE.Vector3()), right = new THREE.Vector3(-ahead.z, 0, ahead.x).normalize();
    const ball = this.hung ?? this.camera.position.clone().addScaledVector(ahead, 1.2).addScaledVector(right, 0.35);
    this.level.ball.visible = $('ball').checked || Boolean(this.hung);
    const flat = new THREE.Vector3(ahead.x, 0, ahead.z).normalize();
    const feet = this.camera.position.clone().addScaledVector(flat, 2.2).addScaledVector(right, -0.5);
    const down = this.level.figure.visible ? this.movement.floorBelow(feet) : null;
    feet.y -= down ?? 1.62;
    this.level.ball.scale.setScalar(this.hung ? 2 / 3 : 1);
    this.level.place(ball, { feet, turn: this.movement.yaw });
    this.level.dome.position.copy(this.camera.position);
    this.level.root.traverse((object) => object.updateMatrix());
    this.level.root.updateMatrixWorld(true);
  }

  // ---- frames

  resize() {
    const canvas = $('canvas');
    const scale = Math.min(window.devicePixelRatio, 2) * Number($('sharpness').value);
    const width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.picture.resize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.wake();
  }

  side(name, i) {
    if (name === TRUTH) return this.truth[i] ? { truth: this.truth[i] } : null;
    const method = this.methods.made.get(name);
    if (!method) return null;
    return {
      draw: () => {
        method.uniforms.heat_full.value = (2 * 0.18 * Math.PI) / this.exposure;
        if (this.chosen >= 0 && name === 'grid') method.uniforms.chosen_record.value = this.marks.data.records[this.chosen];
        this.level.lightBy(method, this.shown);
        this.renderer.render(this.level.root, this.camera);
      },
    };
  }

  get exposure() {
    return this.scene.exposure * 2 ** Number($('exposure').value);
  }
  set exposure(value) {
    $('exposure').value = Math.log2(value / this.scene.exposure);
  }

  draw() {
    this.carry();
    this.picture.show([this.side(this.left, 0), this.side(this.right, 1)], this.divider, this.exposure, this.shown === 'difference');
  }

  wake() {
    if (this.isAwake) return;
    this.isAwake = true;
    let before = performance.now();
    const frame = (now) => {
      const seconds = Math.min(0.1, Math.max(0, (now - before) / 1000));
      before = now;
      if (this.movement.step(seconds)) this.left_();
      this.draw();
      this.countFrame(now);
      this.isAwake = this.movement.isMoving;
      if (this.isAwake) requestAnimationFrame(frame);
      else this.frames.length = 0;
    };
    requestAnimationFrame(frame);
  }

  countFrame(now) {
    this.frames.push(now);
    if (this.frames.length > 30) this.frames.shift();
    if (this.frames.length < 5) return;
    const ms = (now - this.frames[0]) / (this.frames.length - 1);
    $('frameTime').textContent = `${ms.toFixed(1)} ms a frame`;
  }

  // ---- the interface

  fillInterface() {
    const { scene } = this;
    document.title = `${scene.scene}: light grid`;
    $('scene').textContent = scene.scene;
    const option = (value, text) => Object.assign(document.createElement('option'), { value, textContent: text });
    for (const side of ['left', 'right']) {
      for (const name of [...this.methods.entries.keys(), TRUTH]) $(side).append(option(name, this.methods.titleOf(name)));
      $(side).addEventListener('change', (event) => this.choose(side, event.target.value).catch(fail));
    }
    for (const group of new Set(this.places.map((place) => place.group))) {
      const part = Object.assign(document.createElement('optgroup'), { label: group });
      this.places.forEach((place, i) => place.group === group && part.append(option(i, place.name)));
      $('place').append(part);
    }
    $('place').addEventListener('change', (event) => this.goTo(Number(event.target.value)).catch(fail));
    const stepPlace = (by) => this.goTo((Number($('place').value) + by + this.places.length) % this.places.length).catch(fail);
    $('previous').addEventListener('click', () => stepPlace(-1));
    $('next').addEventListener('click', () => stepPlace(1));
    for (const id of ['divider', 'exposure']) $(id).addEventListener('input', () => this.wake());
    $('sharpness').addEventListener('change', () => this.resize());
    $('show').addEventListener('change', (event) => this.show(event.target.value).catch(fail));
    $('chooseProbe').addEventListener('click', () => this.chooseProbe().then(() => this.show('share')).catch(fail));
    for (const id of ['probes', 'cells', 'ball', 'figure']) $(id).addEventListener('change', () => this.toggle().catch(fail));
    $('walk').addEventListener('change', (event) => {
      this.movement.setFlying(!event.target.checked);
      this.wake();
      $('canvas').focus();
    });
    window.addEventListener('keydown', (event) => {
      if (event.target !== $('canvas') || event.ctrlKey || event.altKey || event.metaKey) return;
      const press = { KeyF: 'walk', KeyB: 'ball', KeyG: 'figure', KeyP: 'probes', KeyC: 'cells' }[event.code];
      if (press) $(press).click();
      if (event.code === 'KeyN') stepPlace(1);
      if (event.code === 'KeyX') this.swap();
      if (/^Digit[1-9]$/.test(event.code)) {
        const place = Number(event.code.slice(5)) - 1;
        if (place < this.places.length) this.goTo(place).catch(fail);
      }
    });
    const rows = scene.methods.map((entry) => {
      const row = document.createElement('tr');
      for (const text of [entry.title, bytesText(entry.bytes), entry.rmse_air.toFixed(2), entry.rmse_surface.toFixed(2)]) {
        row.append(Object.assign(document.createElement('td'), { textContent: text }));
      }
      return row;
    });
    $('methods').append(...rows);
    $('placesMeasured').textContent = scene.places.toLocaleString('en');
    $('about').textContent = `Made by nlg-view ${scene.revision}. Light: ${scene.light.join('; ') || 'none'}.`;
    this.dragDivider();
    if (window.innerWidth < 700) $('panel').open = false;
  }

  swap() {
    const [left, right] = [this.right, this.left];
    this.choose('left', left).then(() => this.choose('right', right)).catch(fail);
  }

  dragDivider() {
    const handle = $('handle');
    const place = () => {
      handle.style.left = `${100 * this.divider}%`;
      handle.hidden = this.shown === 'difference';
      $('leftTitle').style.right = `calc(${100 * (1 - this.divider)}% + 20px)`;
      $('rightTitle').style.left = `calc(${100 * this.divider}% + 20px)`;
      // a side that is not there needs no name
      $('leftTitle').hidden = this.divider < 0.05;
      $('rightTitle').hidden = this.divider > 0.95;
      $('leftTitle').textContent = this.methods.titleOf(this.left);
      $('rightTitle').textContent = this.methods.titleOf(this.right);
    };
    const draw = this.draw.bind(this);
    this.draw = () => {
      draw();
      place();
    };
    handle.addEventListener('pointerdown', (event) => {
      handle.setPointerCapture(event.pointerId);
      handle.onpointermove = (move) => {
        $('divider').value = (100 * move.clientX) / window.innerWidth;
        this.wake();
      };
    });
    for (const end of ['pointerup', 'pointercancel']) handle.addEventListener(end, () => (handle.onpointermove = null));
  }

  fillLegend() {
    const counts = this.marks.data?.counts;
    $('legend').hidden = !$('probes').checked || !counts;
    if ($('legend').hidden) return;
    $('legend').replaceChildren(...KINDS.map((kind, i) => {
      const item = document.createElement('li');
      const dot = Object.assign(document.createElement('span'), { className: 'dot' });
      dot.style.background = `rgb(${kind.colour.map((part) => Math.round(255 * part)).join(' ')})`;
      item.append(dot, `${kind.title}: ${counts[i].toLocaleString('en')}`);
      return item;
    }));
  }
}

load('scene')
  .then((scene) => new Viewer(scene).start())
  .catch(fail);
