'use strict';
// The picture: it follows the hand in sketches, as large as there is time for, and is rendered whole when the hand rests.

// Milliseconds that a sketch may take from the question to the pixels.
const SKETCH_TIME = 18;
// Milliseconds without a movement after which the hand rests.
const REST = 120;
const MAX_SKETCHES = 600;
// The sides of enlarged pixels on the page, in its pixels.
const PIXELS = [1, 2, 4, 8, 16, 32, 64];
const LARGEST_PIXEL = 64;
// From which side on the grid of pixels is drawn, and from which on their values are written.
const GRID_FROM = 8;
const VALUES_FROM = 64;

const view = {
  scene: null,
  // The flags that name the edition in which it was read, and those of the text that was sent last.
  openedWith: '',
  readWith: '',
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
  // The image that is painted, and what its pixels cost if that is shown.
  image: null,
  counts: null,
  // The picture on the page: its size there, where it starts in its frame, and the frame's size.
  size: [1, 1],
  origin: [0, 0],
  room: [1, 1],
  // The side of a pixel on the page if it is enlarged, and the place in the picture that is shown in the middle; 0 if the
  // whole picture is shown.
  magnified: 0,
  middle: [0, 0],

  // Takes a scene that is open. The camera stays if it was moved.
  open(scene) {
    [this.scene, this.openedWith] = [scene, this.readWith];
    const stretch = scene.screen.both_sides;
    const screen = { is_stretched: Boolean(stretch), up_as_written: Boolean(stretch && stretch.up_as_written) };
    Object.assign(scene.camera, screen);
    showEdition(scene);
    if (this.camera) {
      Object.assign(this.camera, { ...screen, pivot: pivotOf(this.camera, scene.bounds) });
    }
    this.layout();
    this.rest();
  },

  // Whether the scene is open in the edition that the controls name. If not, it is on its way, or the text is none.
  isOpen() {
    return this.openedWith === editionWords();
  },

  // The camera that is seen with.
  seenWith() {
    return this.camera || new Camera(this.scene.camera, pivotOf(this.scene.camera, this.scene.bounds));
  },

  // Moves the camera, and shows it at once.
  change(move, time = performance.now()) {
    this.camera = this.seenWith();
    move(this.camera);
    this.camera.round();
    this.finished = false;
    this.moves.push(time);
    this.stale = true;
    drawOverlay();
    this.sketch();
  },

  question(words = wordsOf()) {
    const camera = this.camera ? this.camera.block() : null;
    return { scene: this.scene.revision, words, camera, cost: shown() };
  },

  // Paints sketches, one after the other, as long as the hand moves.
  async sketch() {
    if (this.sketching || !this.isOpen()) return;
    this.sketching = true;
    clearTimeout(this.restTimer);
    try {
      while (this.stale) {
        this.stale = false;
        const moves = this.moves.splice(0);
        const sides = size().map((side) => Math.max(1, Math.round(side * this.scale)));
        const start = performance.now();
        const { meta, bytes } = await ask('/picture', { view: this.question(), sketch: sides });
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

  // The hand rests: the whole picture, and then finer ones.
  rest() {
    this.finished = false;
    if (!this.scene || this.sketching) return;
    clearTimeout(this.restTimer);
    this.restTimer = setTimeout(() => this.whole(), 0);
  },

  async whole(exactly = false) {
    if (!this.isOpen()) return;
    this.finished = false;
    try {
      status('rendering …');
      await this.render(wordsOf(), 'whole');
      lookAround();
      if (comparing()) await compareLive();
      else if (!exactly && refines()) await this.refine();
      this.finished = true;
    } catch (error) {
      if (error.status === CLOSED) return editorSends();
      if (error.status !== OVERTAKEN) status('');
      complain(error);
    }
  },

  // Takes more samples, until the picture is converged.
  async refine() {
    for (const [most, error] of FINER) {
      await this.render(wordsOf(['-adaptive_samples', `${most}`, `${error}`]), `${most} samples`);
    }
    status(`converged, ${size().join(' × ')}`);
  },

  // Paints a picture that its command line writes, byte for byte.
  async render(words, stage) {
    const { meta, bytes } = await ask('/picture', { view: this.question(words) });
    this.paint(meta, bytes, stage);
    find('command').value = meta.command;
    find('block').value = this.seenWith().block().trimEnd();
    for (const id of ['home', 'keep']) find(id).disabled = !this.camera;
    find('costs').hidden = !meta.costs;
    find('costs').textContent = groupedIn(meta.costs || '');
    status(`${stage}, ${meta.shows.join(' × ')}, ${duration(meta.milliseconds)}`);
    if (meta.nans > 0) say(`The colours of ${grouped(meta.nans)} pixels are not numbers; they are black.`);
  },

  paint(meta, bytes, stage) {
    const [width, height] = meta.size;
    this.stage = stage;
    this.counts = meta.costs ? new Uint32Array(bytes.slice(width * height * 4).buffer) : null;
    this.show(new ImageData(bytes.subarray(0, width * height * 4), width, height));
  },

  show(image) {
    const { canvas } = this;
    this.image = image;
    if (canvas.width !== image.width || canvas.height !== image.height) {
      [canvas.width, canvas.height] = [image.width, image.height];
      this.layout();
    }
    this.context.putImageData(image, 0, 0);
    if (this.stage === 'sketch') return;
    if (pointed) point(pointed);
    if (this.magnified) drawOverlay();
  },

  // How much wider the image is than the picture: a map of costs has a scale beside it.
  wider() {
    return this.counts && this.image ? this.image.width / size()[0] : 1;
  },

  // Gives the picture the room that there is: a whole number of the screen's pixels for each pixel, if that leaves little
  // of the room.
  layout() {
    const [width, height] = size();
    const room = find('frame').getBoundingClientRect();
    const fit = Math.min(room.width / (width * this.wider()), room.height / height);
    const screen = window.devicePixelRatio || 1;
    const whole = Math.floor(fit * screen) / screen;
    const zoom = this.magnified || (whole > 0.8 * fit ? whole : fit);
    this.canvas.classList.toggle('uneven', !Number.isInteger(zoom * screen));
    this.room = [room.width, room.height];
    this.size = [width * zoom, height * zoom];
    const sides = [this.size[0] * this.wider(), this.size[1]];
    this.origin = sides.map((side, axis) => {
      const free = this.room[axis] - side;
      if (!this.magnified || free >= 0) return free / 2;
      return Math.round(Math.max(free, Math.min(0, this.room[axis] / 2 - this.middle[axis] * zoom)));
    });
    const { style } = this.canvas;
    [style.width, style.height, style.left, style.top] = [...sides, ...this.origin].map((side) => `${side}px`);
    find('zoomed').textContent = this.magnified ? `${this.magnified}×` : 'fits';
    find('zoomed').disabled = find('zoom-out').disabled = !this.magnified;
    find('zoom-in').disabled = this.magnified >= LARGEST_PIXEL;
    drawOverlay();
  },

  // Enlarges the pixels by one step, or makes them smaller by one; `at` is the place of the window that stays where it is.
  magnify(step, at = null) {
    const [width] = size();
    const now = this.size[0] / width;
    const steps = PIXELS.filter((side) => side > (this.magnified ? 0 : now));
    const place = this.magnified ? PIXELS.indexOf(this.magnified) + step : PIXELS.indexOf(steps[0]) + step - 1;
    if (!this.magnified && step < 0) return;
    const frame = find('frame').getBoundingClientRect();
    const offset = at ? [at[0] - frame.left, at[1] - frame.top] : this.room.map((side) => side / 2);
    const still = offset.map((side, axis) => (side - this.origin[axis]) / now);
    this.magnified = PIXELS[Math.min(place, PIXELS.length - 1)] || 0;
    // Where the whole picture is as large, it is shown.
    this.middle = still.map((side, axis) => side + (this.room[axis] / 2 - offset[axis]) / (this.magnified || 1));
    this.layout();
  },

  // Moves the enlarged picture, by this way on the page.
  pan(across, down) {
    // From where it is: it stops at its edges.
    const now = this.room.map((side, axis) => (side / 2 - this.origin[axis]) / this.magnified);
    this.middle = [now[0] - across / this.magnified, now[1] - down / this.magnified];
    this.layout();
  },

  // The columns and rows of a map of this size that are in sight: from and up to.
  visible(sides) {
    const part = (pixels, axis) => ((pixels - this.origin[axis]) / this.size[axis]) * sides[axis];
    const first = sides.map((_, axis) => Math.max(0, Math.floor(part(0, axis))));
    const last = sides.map((side, axis) => Math.min(side, Math.ceil(part(this.room[axis], axis))));
    return [...first, ...last];
  },

  // The colour of a pixel in an image of the whole picture.
  colorIn(image, [x, y]) {
    const [width, height] = size();
    if (image.width < width || image.height !== height) return null;
    return [...image.data.subarray((y * image.width + x) * 4, (y * image.width + x) * 4 + 3)];
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

// Draws lines between enlarged pixels, and writes their values into them where there is room.
function drawPixels(context) {
  const side = view.magnified;
  if (side < GRID_FROM) return;
  const [left, top, right, bottom] = view.visible(size());
  context.fillStyle = 'rgb(128 128 128 / .55)';
  for (let x = left; x <= right; x++) context.fillRect(x * side, top * side, 1, (bottom - top) * side);
  for (let y = top; y <= bottom; y++) context.fillRect(left * side, y * side, (right - left) * side, 1);
  if (side < VALUES_FROM || !view.image || view.counts) return;
  [context.font, context.textAlign] = ['12px ui-monospace, monospace', 'center'];
  for (let y = top; y < bottom; y++) {
    for (let x = left; x < right; x++) {
      const color = view.colorIn(view.image, [x, y]);
      if (!color) return;
      const light = 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2];
      context.fillStyle = light > 128 ? '#000' : '#fff';
      color.forEach((level, line) => context.fillText(`${level}`, (x + 0.5) * side, y * side + 20 + 15 * line));
    }
  }
}
