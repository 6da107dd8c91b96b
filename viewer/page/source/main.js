// The page of nlg-view.
import * as THREE from 'three';
import { Data } from './data.js';
import { Level } from './level.js';
import { KINDS, Marks } from './marks.js';
import { Methods, TRUTH } from './methods.js';
import { Movement } from './movement.js';
import { Picture } from './picture.js';

const root = document.documentElement;
const $ = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search); // a test asks for a view: ?place=0&left=grid&right=ddgi&divider=1&ui=0

// What went wrong, where everybody sees it; tests read it too.
function fail(error) {
  console.error(error);
  root.dataset.error = String(error.message ?? error);
  $('message').textContent = `This page cannot go on: ${error.message ?? error}`;
  $('message').hidden = false;
}

// What went wrong with one choice; the page goes on.
function warn(error) {
  console.warn(error);
  $('message').textContent = error.message ?? String(error);
  $('message').hidden = false;
}

const ASK_EVERY_MS = 500; // what goes on

const bytesText = (bytes) => (bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.round(bytes / 1e3)} kB`);

// ".09", "1.24"; of what was measured
const errorText = (error) => error.toFixed(2).replace(/^0/, '');

// "9 kB · error .09 in air, .12 on surfaces"
const costText = ({ bytes, rmse_air, rmse_surface }) =>
  bytesText(bytes) + (rmse_air === undefined ? '' : ` · error ${errorText(rmse_air)} in air, ${errorText(rmse_surface)} on surfaces`);

// The light state that a group of light is of; empty: of none.
const setOf = (group) => group.slice(0, Math.max(0, group.indexOf('/')));

const option = (value, text) => Object.assign(document.createElement('option'), { value, textContent: text });

class Viewer {
  constructor(scene, data) {
    const canvas = $('canvas');
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    if (!this.renderer.extensions.has('EXT_color_buffer_float') && !this.renderer.extensions.has('EXT_color_buffer_half_float')) {
      throw new Error('this browser draws no pictures in half floats (EXT_color_buffer_half_float)');
    }
    this.picture = new Picture(this.renderer);
    // near enough for views that were chosen millimetres before a wall
    this.camera = new THREE.PerspectiveCamera(60, 1, 0.004, 10);
    this.movement = new Movement(this.camera, canvas);
    this.movement.onChange = () => this.wake();
    this.left = 'grid';
    this.right = null;
    this.wanted = {}; // by side, also where a scene has no such method
    this.shown = 'light';
    this.lights = new Map(); // by group: its slider and its colour
    this.enter(scene, data, new Methods(scene, data));
    this.placeExposure = this.places[0].exposure; // of the last place that was gone to
    this.at = null; // the place that the camera stands at, until it moves
    this.frames = [];
    this.detail = 1; // share of the sharpness: less while a slow machine moves
    this.truthAsked = 0;
  }

  // From here on this scene is the one that is shown; the camera stays where it is.
  enter(scene, data, methods) {
    this.scene = scene;
    this.methods = methods;
    this.level = new Level(scene, methods.looks);
    this.marks = new Marks(this.level.root, data);
    this.camera.far = Math.max(10, 2 * this.level.bounds.getSize(new THREE.Vector3()).length());
    this.camera.updateProjectionMatrix();
    this.movement.enter(this.level.geometry, this.level.bounds);
    this.truth = null; // of the view that the camera stands at
    this.chosen = -1;
    this.places = [
      ...scene.views.map((view, i) => (scene.has_truth ? { ...view, group: 'views with path tracing', truth: i } : { ...view, group: 'views' })),
      ...scene.starts.map((start) => ({ ...start, group: 'where players begin' })),
      ...scene.worst.map((worst) => ({ ...worst, group: 'where the grid is most wrong' })),
    ];
  }

  // The scene as it was saved again: whatever was chosen stays, where it is still there.
  async renew(scene, data) {
    const methods = new Methods(scene, data);
    const wanted = { ...this.wanted };
    const [left, right] = [wanted.left, wanted.right].map((name) => (methods.has(name) ? name : 'grid'));
    // the picture stays until there is all of the next one
    for (const name of new Set(['grid', left, right])) if (name !== TRUTH) await methods.rendered(name);
    const { level, methods: before, at } = this;
    [this.left, this.right] = [left, right];
    this.enter(scene, data, methods);
    const place = at ? this.places.findIndex(({ eye, forward }) => String([eye, forward]) === String([at.eye, at.forward])) : -1;
    this.at = this.places[place] ?? null;
    this.hung = this.at?.place ? this.hung : null;
    this.fillScene();
    $('place').value = place;
    if (!this.hung) $('placeNote').textContent = '';
    this.marks.showPlace(this.at?.place, this.at?.normal);
    await this.choose('left', left);
    await this.choose('right', right);
    // a preview has no ground truth
    this.wanted = wanted;
    await this.fillLights();
    await this.toggle();
    $('probe').textContent = '';
    if (this.shown === 'share') await this.chooseProbe();
    this.draw();
    level.dispose();
    before.dispose();
  }

  async start() {
    this.fillInterface();
    this.fillScene();
    await this.choose('left', asked.get('left') ?? 'grid');
    await this.choose('right', asked.get('right') ?? this.methods.names.at(-1));
    await this.fillLights();
    // at first the whole picture is the grid's; the handle at its edge invites to compare
    $('divider').value = 100 * Number(asked.get('divider') ?? 1);
    if (asked.get('ui') === '0') document.body.classList.add('bare');
    for (const mark of ['probes', 'cells', 'ball', 'figure']) {
      if (asked.get(mark) === '1') $(mark).checked = true;
    }
    await this.toggle();
    await this.goTo(Number(asked.get('place') ?? 0));
    if (asked.has('exposure')) this.exposure = Number(asked.get('exposure'));
    if (asked.has('show')) await this.show(asked.get('show'));
    // coarse at first, so that a slow machine shows something soon
    this.detail = 0.25;
    this.resize();
    root.dataset.firstFrameMs = this.drawn();
    this.detail = 1;
    this.resize();
    root.dataset.fullFrameMs = this.drawn();
    new ResizeObserver(() => this.resize()).observe($('canvas'));
    $('canvas').focus({ preventScroll: true });
    root.dataset.ready = '1';
  }

  // Milliseconds since the page was opened at which the frame that was asked for is there: who reads a pixel waits for it.
  drawn() {
    this.renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    return Math.round(performance.now());
  }

  // A slider and a colour for each group of light that the grid keeps apart; groups that are called SET/GROUP have those of their set
  // besides. ?light=sky:0&light=lamps:1.5 sets them at once.
  async fillLights() {
    const grid = await this.busy(this.methods.rendered('grid'));
    const given = new Map(asked.getAll('light').map((one) => [one.slice(0, one.lastIndexOf(':')), one.slice(one.lastIndexOf(':') + 1)]));
    const rows = [];
    const add = (name, title, begins) => {
      const row = document.createElement('label');
      const before = this.lights.get(name);
      const factor = Object.assign(document.createElement('input'), { type: 'range', min: 0, max: 2, step: 0.01, value: before?.factor.value ?? given.get(name) ?? begins });
      const tint = Object.assign(document.createElement('input'), { type: 'color', value: before?.tint.value ?? '#ffffff', title: `colour of ${name}` });
      for (const input of [factor, tint]) input.addEventListener('input', () => this.mixLights(grid));
      row.append(`${title} `, factor, tint);
      row.classList.toggle('ofSet', title !== name);
      this.lights.set(name, { factor, tint });
      rows.push(row);
    };
    let last;
    for (const name of grid.groups) {
      const set = setOf(name);
      if (set && set !== last) add(set, set, grid.begins.get(name));
      last = set;
      add(name, name.slice(set ? set.length + 1 : 0), set ? 1 : grid.begins.get(name));
    }
    $('groups').replaceChildren(...rows);
    $('lights').hidden = rows.length === 0;
    if (rows.length > 0) this.mixLights(grid);
  }

  mixLights(grid) {
    const chosen = (name) => {
      const { factor, tint } = this.lights.get(name);
      return new THREE.Color(tint.value).toArray().map((channel) => channel * Number(factor.value));
    };
    const colours = grid.groups.map((name) => {
      const own = chosen(name), set = setOf(name);
      return set ? chosen(set).map((factor, channel) => factor * own[channel]) : own;
    });
    grid.mix(colours);
    const colourOf = (name) => colours[grid.groups.indexOf(name)] ?? [1, 1, 1];
    this.level.tintSky(colourOf);
    this.level.tintShine(colourOf);
    this.wake();
  }

  get divider() {
    return Number($('divider').value) / 100;
  }

  // ---- what is shown

  async choose(side, name) {
    if (!this.methods.has(name)) throw new Error(`no method ${name}; there are ${this.methods.names.join(', ')}`);
    const before = this[side] ?? 'grid';
    this[side] = this.wanted[side] = $(side).value = name;
    try {
      if (name !== TRUTH) await this.busy(this.methods.rendered(name));
    } catch (error) {
      if (this[side] === name) this[side] = $(side).value = before;
      throw error;
    }
    await this.readTruth();
    $('message').hidden = true;
    this.wake();
  }

  // A stored picture is right for one camera only.
  async readTruth() {
    const view = this.at?.truth;
    const request = ++this.truthAsked;
    const isAsked = [this.left, this.right].includes(TRUTH) && view !== undefined;
    this.truth = null;
    const truth = isAsked ? await this.busy(this.methods.truth(view)) : null;
    // the camera may have gone on meanwhile
    if (request !== this.truthAsked) return;
    this.truth = truth;
    this.wake();
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
    if (![...$('show').options].some((option) => option.value === what)) throw new Error(`nothing called ${what} can be shown`);
    $('show').value = this.shown = what;
    if (this.showsGridAlone) await this.busy(this.methods.rendered('grid'));
    if (what === 'share' && this.chosen < 0) await this.chooseProbe();
    this.wake();
  }

  // Leaks and shares are the light grid's own.
  get showsGridAlone() {
    return this.shown === 'leaks' || this.shown === 'share';
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
    this.wake();
  }

  // ---- from where

  async goTo(index) {
    const place = this.places[index];
    if (!place) throw new Error(`no place ${index}; there are ${this.places.length}`);
    this.movement.lookFrom(new THREE.Vector3(...place.eye), new THREE.Vector3(...place.forward), THREE.MathUtils.radToDeg(place.fov_y));
    this.placeExposure = place.exposure;
    this.at = place;
    $('place').value = index;
    this.marks.showPlace(place.place, place.normal);
    $('placeNote').textContent = place.error === undefined ? '' : `error ${errorText(place.error)}`;
    this.hung = place.place ? new THREE.Vector3(...place.place) : null;
    await this.readTruth();
    this.wake();
  }

  leavePlace() {
    if (!this.at) return;
    this.at = this.hung = null;
    $('placeNote').textContent = '';
    this.readTruth().catch(warn);
  }

  carry() {
    const ahead = this.camera.getWorldDirection(new THREE.Vector3()), right = new THREE.Vector3(-ahead.z, 0, ahead.x).normalize();
    const ball = this.hung ?? this.camera.position.clone().addScaledVector(ahead, 1.2).addScaledVector(right, 0.35);
    // ground truth knows nothing of what is carried
    const isBare = !this.showsGridAlone && [this.left, this.right].includes(TRUTH);
    this.level.ball.visible = !isBare && ($('ball').checked || Boolean(this.hung));
    this.level.figure.visible = !isBare && $('figure').checked;
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
    const scale = Math.min(window.devicePixelRatio, 2) * Number($('sharpness').value) * this.detail;
    const width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.picture.resize(width, height, canvas.clientWidth);
    this.camera.aspect = canvas.clientWidth / canvas.clientHeight;
    this.camera.updateProjectionMatrix();
    // at once: a canvas of another size is black
    this.draw();
  }

  side(name) {
    if (name === TRUTH) return this.truth ? { truth: this.truth } : null;
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
    return this.placeExposure * 2 ** Number($('exposure').value);
  }
  set exposure(value) {
    $('exposure').value = Math.log2(value / this.placeExposure);
  }

  draw() {
    this.carry();
    if (this.showsGridAlone) this.picture.show([this.side('grid'), null], 1, this.exposure, false);
    else this.picture.show([this.side(this.left), this.side(this.right)], this.divider, this.exposure, this.shown === 'difference');
    this.label();
  }

  wake() {
    if (this.isAwake) return;
    this.isAwake = true;
    let before = performance.now();
    const frame = (now) => {
      const seconds = Math.min(0.1, Math.max(0, (now - before) / 1000));
      before = now;
      if (this.movement.step(seconds)) this.leavePlace();
      this.draw();
      this.countFrame(now);
      this.isAwake = this.movement.isMoving;
      if (this.isAwake) requestAnimationFrame(frame);
      else this.rest();
    };
    requestAnimationFrame(frame);
  }

  countFrame(now) {
    this.frames.push(now);
    if (this.frames.length > 30) this.frames.shift();
    if (this.frames.length < 5) return;
    const ms = (now - this.frames[0]) / (this.frames.length - 1);
    $('frameTime').textContent = `${ms.toFixed(1)} ms from frame to frame`;
    if (ms > 100 && this.detail > 0.25) {
      this.detail /= 2;
      this.frames.length = 0;
      this.resize();
    }
  }

  rest() {
    this.frames.length = 0;
    if (this.detail === 1) return;
    this.detail = 1;
    this.resize();
  }

  // ---- the interface

  // What is there for every scene.
  fillInterface() {
    for (const side of ['left', 'right']) $(side).addEventListener('change', (event) => this.choose(side, event.target.value).catch(warn));
    $('place').addEventListener('change', (event) => this.goTo(Number(event.target.value)).catch(warn));
    const stepPlace = (by) => this.goTo((Number($('place').value) + by + this.places.length) % this.places.length).catch(warn);
    $('previous').addEventListener('click', () => stepPlace(-1));
    $('next').addEventListener('click', () => stepPlace(1));
    for (const id of ['divider', 'exposure']) $(id).addEventListener('input', () => this.wake());
    $('sharpness').addEventListener('change', () => this.resize());
    $('show').addEventListener('change', (event) => this.show(event.target.value).catch(warn));
    $('chooseProbe').addEventListener('click', () => this.chooseProbe().then(() => this.show('share')).catch(warn));
    for (const id of ['probes', 'cells', 'ball', 'figure']) $(id).addEventListener('change', () => this.toggle().catch(warn));
    $('walk').addEventListener('change', (event) => {
      this.movement.setFlying(!event.target.checked);
      this.wake();
      $('canvas').focus();
    });
    // who chose with a mouse or a thumb goes on moving; who chose with keys is still choosing
    let byPointer = false;
    $('panel').addEventListener('pointerdown', () => (byPointer = true), true);
    $('panel').addEventListener('keydown', () => (byPointer = false), true);
    $('panel').addEventListener('change', () => byPointer && $('canvas').focus());
    $('jump').addEventListener('pointerdown', (event) => {
      event.preventDefault();
      this.movement.press('Space');
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave']) $('jump').addEventListener(end, () => this.movement.release('Space'));
    window.addEventListener('keydown', (event) => {
      if (event.target !== $('canvas') || event.ctrlKey || event.altKey || event.metaKey) return;
      const press = { KeyF: 'walk', KeyB: 'ball', KeyG: 'figure', KeyP: 'probes', KeyC: 'cells' }[event.code];
      if (press) $(press).click();
      if (event.code === 'KeyN') stepPlace(1);
      if (event.code === 'KeyX') this.swap();
      if (/^Digit[1-9]$/.test(event.code)) {
        const place = Number(event.code.slice(5)) - 1;
        if (place < this.places.length) this.goTo(place).catch(warn);
      }
    });
    this.dragDivider();
    if (window.innerWidth < 700) $('panel').open = false;
  }

  // What a scene brings along.
  fillScene() {
    const { scene } = this;
    document.title = `${scene.scene}: light grid`;
    $('scene').textContent = scene.scene;
    for (const side of ['left', 'right']) $(side).replaceChildren(...this.methods.names.map((name) => option(name, this.methods.titleOf(name))));
    $('place').replaceChildren(...[...new Set(this.places.map((place) => place.group))].map((group) => {
      const part = Object.assign(document.createElement('optgroup'), { label: group });
      this.places.forEach((place, i) => place.group === group && part.append(option(i, place.name)));
      return part;
    }));
    $('methods').replaceChildren(...scene.methods.map((entry) => {
      const row = document.createElement('tr');
      for (const text of [entry.title, costText(entry)]) {
        row.append(Object.assign(document.createElement('td'), { textContent: text }));
      }
      return row;
    }));
    $('filtered').hidden = !scene.has_truth;
    $('measured').hidden = scene.air_samples + scene.surface_samples === 0;
    $('airPlaces').textContent = scene.air_samples.toLocaleString('en');
    $('surfacePlaces').textContent = scene.surface_samples.toLocaleString('en');
    $('warnings').textContent = scene.warnings.join(' ');
    $('about').textContent = `Made by nlg-view ${scene.revision}. Light: ${scene.light.join('; ') || 'none'}.`;
  }

  swap() {
    const [left, right] = [this.right, this.left];
    this.choose('left', left).then(() => this.choose('right', right)).catch(warn);
  }

  // The divider's handle, and the names of what is shown.
  label() {
    const handle = $('handle');
    const title = (name) => this.methods.titleOf(name) + (name === TRUTH && !this.truth ? ': only at stored views, press N' : '');
    const isSplit = this.shown === 'light';
    handle.hidden = !isSplit || (this.left === this.right && this.divider === 1);
    handle.style.left = `min(${100 * this.divider}%, 100% - 16px)`;
    $('invitation').hidden = this.divider < 0.95;
    $('invitation').textContent = `drag to compare with ${title(this.right)}`;
    $('leftTitle').style.right = isSplit ? `calc(${100 * (1 - this.divider)}% + 20px)` : '20px';
    $('rightTitle').style.left = `calc(${100 * this.divider}% + 20px)`;
    // a side that is not there needs no name
    $('leftTitle').hidden = isSplit && this.divider < 0.05;
    $('rightTitle').hidden = !isSplit || this.divider > 0.95;
    $('rightTitle').textContent = title(this.right);
    if (isSplit) $('leftTitle').textContent = title(this.left);
    else if (this.showsGridAlone) $('leftTitle').textContent = `${title('grid')}: ${this.shown}`;
    else $('leftTitle').textContent = `${title(this.right)} minus ${title(this.left)}`;
  }

  dragDivider() {
    const handle = $('handle');
    let hasMoved = false;
    handle.addEventListener('pointerdown', (event) => {
      hasMoved = false;
      handle.setPointerCapture(event.pointerId);
      handle.onpointermove = (move) => {
        hasMoved = true;
        $('divider').value = (100 * move.clientX) / window.innerWidth;
        this.wake();
      };
    });
    // who only taps it at the edge gets both halves
    handle.addEventListener('click', () => {
      if (hasMoved || this.divider < 0.95) return;
      $('divider').value = 50;
      this.wake();
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

// number   of a set of scripts; none: those beside the page
async function openScene(number) {
  const data = new Data(number);
  return [await data.load('scene'), data];
}

// The viewer; null where it cannot be.
async function begin(scene, data) {
  try {
    const viewer = new Viewer(scene, data);
    await viewer.start();
    return viewer;
  } catch (error) {
    fail(error);
    return null;
  }
}

// A page that `nlg-view --watch` serves shows each set of scripts as it comes, and says what goes on.
async function follow() {
  const status = $('status'), [words, bar] = status.children;
  let viewer = null, shown = 0;
  status.hidden = false;
  for (;;) {
    const state = await fetch('state').then((answer) => answer.json()).catch(() => ({ shown, text: 'nlg-view has ended', failed: true, busy: false }));
    words.textContent = state.text + (state.stage ? ` ${state.stage}` : '');
    bar.hidden = !state.busy;
    // of what cannot be counted the bar just moves
    if (state.share === null || !state.busy) bar.removeAttribute('value');
    else bar.value = state.share;
    status.classList.toggle('failed', state.failed);
    if (state.shown !== shown) {
      shown = state.shown;
      try {
        const [scene, data] = await openScene(shown);
        // all that it is shown by, before anything is
        const { left, right } = viewer?.wanted ?? { left: asked.get('left'), right: asked.get('right') };
        for (const { name } of scene.methods) if (['grid', left, right].includes(name)) await data.load(`method-${name}`);
        if (viewer) await viewer.renew(scene, data);
        else if (!(viewer = await begin(scene, data))) return;
        root.dataset.shown = shown;
      } catch (error) {
        // where others have taken their place meanwhile, those come next
        warn(error);
      }
    }
    await new Promise((done) => setTimeout(done, ASK_EVERY_MS));
  }
}

if (root.dataset.served) {
  follow();
} else {
  openScene().then(([scene, data]) => begin(scene, data)).catch(fail);
}
