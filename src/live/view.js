'use strict';
// The picture: it follows the hand in sketches, as large as there is time for, and is rendered whole when the hand rests.

// Milliseconds that a sketch may take from the question to the pixels.
const SKETCH_TIME = 18;
// Milliseconds without a movement after which the hand rests.
const REST = 120;
const MAX_SKETCHES = 600;

const view = {
  scene: null,
  // The camera that the hand has moved; none while it is the scene's own.
  camera: null,
  canvas: find('picture'),
  context: find('picture').getContext('2d', { alpha: false, willReadFrequently: true }),
  // The side of a sketch, as a part of the picture's.
  scale: 0.5,
  sketching: false,
  stale: false,
  restTimer: 0,
  // When the movements happened that the next sketch shows.
  moves: [],
  // Of the last sketches: when the hand moved, when the pixels were painted, and how many there were.
  sketches: [],
  // What is painted: 'sketch', 'whole', or the number of the refinement's samples.
  stage: '',
  // Whether nothing better is on its way.
  finished: false,
  size: [1, 1],

  // Takes a scene that is open. The camera stays if it was moved.
  open(scene) {
    this.scene = scene;
    if (this.camera) this.camera.pivot = pivotOf(this.camera, scene.bounds);
    this.layout();
    this.rest();
  },

  // The camera that is seen with.
  seenWith() {
    return this.camera || new Camera(this.scene.camera, pivotOf(this.scene.camera, this.scene.bounds));
  },

  // Moves the camera, and shows it at once.
  change(move, time = performance.now()) {
    this.camera = this.seenWith();
    move(this.camera);
    this.finished = false;
    this.moves.push(time);
    this.stale = true;
    drawOverlay();
    this.sketch();
  },

  question(words = wordsOf()) {
    const camera = this.camera ? this.camera.block() : null;
    return { scene: this.scene.revision, words, camera, show: shown() };
  },

  // Paints sketches, one after the other, as long as the hand moves.
  async sketch() {
    if (this.sketching) return;
    this.sketching = true;
    clearTimeout(this.restTimer);
    try {
      while (this.stale) {
        this.stale = false;
        const moves = this.moves.splice(0);
        const sides = size().map((side) => Math.max(1, Math.round(side * this.scale)));
        const start = performance.now();
        const { meta, bytes } = await ask('/picture', { page, turn: ++turn, view: this.question(), sketch: sides });
        this.paint(meta, bytes, 'sketch');
        this.adapt(performance.now() - start);
        requestAnimationFrame(() => this.note({ moves, paintedAt: performance.now(), sides }));
      }
    } catch (error) {
      complain(error);
    }
    this.sketching = false;
    clearTimeout(this.restTimer);
    this.restTimer = setTimeout(() => this.whole(), REST);
  },

  // Chooses the size of the next sketch by the time that the last ones took.
  adapt(took) {
    const factor = Math.sqrt(SKETCH_TIME / took);
    this.scale = Math.max(0.08, Math.min(1, this.scale * Math.max(0.75, Math.min(1.08, factor))));
  },

  note(sketch) {
    this.sketches.push(sketch);
    if (this.sketches.length > MAX_SKETCHES) this.sketches.shift();
    const last = this.sketches.slice(-20);
    const span = last[last.length - 1].paintedAt - last[0].paintedAt;
    const rate = last.length > 1 ? ((last.length - 1) * 1000) / span : 0;
    status(`${rate.toFixed(0)} pictures/s, ${sketch.sides.join(' × ')}`);
  },

  // The hand rests: the whole picture, and then finer ones. What is on its way is overtaken.
  rest() {
    this.finished = false;
    if (!this.scene || this.sketching) return;
    clearTimeout(this.restTimer);
    this.restTimer = setTimeout(() => this.whole(), 0);
  },

  async whole(exactly = false) {
    const mine = ++turn;
    this.finished = false;
    try {
      status('rendering …');
      await this.render(wordsOf(), 'whole', mine);
      lookAround();
      if (comparing()) await compareLive(mine);
      else if (!exactly && refines()) await this.refine(mine);
      this.finished = mine === turn;
    } catch (error) {
      if (error.status === CLOSED) return editorSends();
      if (error.status !== OVERTAKEN) status('');
      complain(error);
    }
  },

  // Takes more samples, until the picture is converged.
  async refine(mine) {
    for (const [most, error] of FINER) {
      await this.render(wordsOf(['-adaptive_samples', `${most}`, `${error}`]), `${most} samples`, mine);
    }
    status(`converged, ${size().join(' × ')}`);
  },

  // Paints a picture that its command line writes, byte for byte.
  async render(words, stage, mine) {
    const { meta, bytes } = await ask('/picture', { page, turn: mine, view: this.question(words), sketch: null });
    if (mine !== turn || this.sketching) throw new Refused(OVERTAKEN, '');
    this.paint(meta, bytes, stage);
    find('command').value = meta.command;
    find('block').value = this.seenWith().block().trimEnd();
    for (const id of ['home', 'keep']) find(id).disabled = !this.camera;
    find('costs').hidden = !meta.costs;
    find('costs').textContent = meta.costs || '';
    status(`${stage}, ${meta.shows.join(' × ')}, ${meta.milliseconds.toFixed(1)} ms`);
    if (meta.nans > 0) say(`The colours of ${meta.nans} pixels are not numbers; they are black.`);
  },

  paint(meta, bytes, stage) {
    this.show(new ImageData(bytes, meta.size[0], meta.size[1]));
    this.stage = stage;
    // A map of costs has a scale beside the picture.
    const wider = meta.size[0] / meta.shows[0];
    this.canvas.style.width = `${this.size[0] * wider}px`;
  },

  show(image) {
    const { canvas } = this;
    if (canvas.width !== image.width || canvas.height !== image.height) {
      [canvas.width, canvas.height] = [image.width, image.height];
    }
    this.context.putImageData(image, 0, 0);
  },

  // Gives the picture the room that there is: a whole number of the screen's pixels for each pixel, if they fit.
  layout() {
    const [width, height] = size();
    const room = find('frame').getBoundingClientRect();
    const fit = Math.min(room.width / width, room.height / height);
    const screen = window.devicePixelRatio || 1;
    const zoom = fit * screen >= 1 ? Math.floor(fit * screen) / screen : fit;
    this.size = [width * zoom, height * zoom];
    [this.canvas.style.width, this.canvas.style.height] = this.size.map((side) => `${side}px`);
    drawOverlay();
  },

  // The pixel at a place of the window, if it shows one.
  pixelAt(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const [width, height] = size();
    const pixel = [((x - box.left) / this.size[0]) * width, ((y - box.top) / this.size[1]) * height].map(Math.floor);
    return pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < width && pixel[1] < height ? pixel : null;
  },
};

function status(text) {
  find('status').textContent = text;
}
