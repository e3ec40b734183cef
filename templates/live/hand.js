'use strict';
// The hand: mouse, touch and wheel on the picture, and the keys.

// The fingers or buttons that are down, by their pointers' ids.
const held = new Map();
let pointed = null;
// Where the pointer is in the window, if it is on the picture.
let hovered = null;

const longerSide = () => Math.max(...view.size);

function dragged(event, before) {
  if (view.magnified) return view.pan(event.clientX - before.x, event.clientY - before.y);
  const [across, down] = [event.clientX - before.x, event.clientY - before.y].map((way) => way / longerSide());
  const time = event.timeStamp;
  if (held.size === 2) return pinched(event, before, time);
  const moves = before.button === 1 || event.shiftKey;
  if (moves) view.change((camera) => camera.move(across, down), time);
  else if (before.button === 2) view.change((camera) => camera.approach(Math.exp(2 * down)), time);
  else view.change((camera) => camera.turn(Math.PI * across, Math.PI * down), time);
}

// Two fingers: their middle moves the scene, and their distance brings it nearer.
function pinched(event, before, time) {
  const other = [...held.entries()].find(([id]) => id !== event.pointerId)[1];
  const apart = (x, y) => Math.hypot(x - other.x, y - other.y) || 1;
  const factor = apart(before.x, before.y) / apart(event.clientX, event.clientY);
  const way = [event.clientX - before.x, event.clientY - before.y].map((side) => side / 2 / longerSide());
  view.change((camera) => {
    camera.move(...way);
    camera.approach(factor);
  }, time);
}

function startHand() {
  const { canvas } = view;
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    held.set(event.pointerId, { x: event.clientX, y: event.clientY, button: event.button });
    event.preventDefault();
  });
  canvas.addEventListener('pointermove', (event) => {
    hovered = [event.clientX, event.clientY];
    point(view.pixelAt(...hovered));
    const before = held.get(event.pointerId);
    if (!before) return;
    dragged(event, before);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY, button: before.button });
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, (event) => held.delete(event.pointerId));
  }
  // A finger that is lifted has still pointed there.
  canvas.addEventListener('pointerleave', (event) => {
    hovered = null;
    if (event.pointerType !== 'touch') point(null);
  });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('auxclick', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    if (view.magnified) return view.magnify(event.deltaY < 0 ? 1 : -1, [event.clientX, event.clientY]);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    view.change((camera) => camera.approach(Math.exp(0.12 * lines)), event.timeStamp);
  }, { passive: false });
  canvas.addEventListener('keydown', steer);
  find('zoom-in').addEventListener('click', () => view.magnify(1));
  find('zoom-out').addEventListener('click', () => view.magnify(-1));
  find('zoomed').addEventListener('click', () => view.magnify(-Infinity));
  document.addEventListener('keydown', press);
}

const STEP = 1 / 36;

// The keys that move the picture that has the focus.
function steer(event) {
  const ways = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] };
  const way = ways[event.key];
  const nearer = { '+': 0.9, '=': 0.9, '-': 1 / 0.9 }[event.key];
  if ((!way && !nearer) || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  if (view.magnified && nearer) view.magnify(nearer < 1 ? 1 : -1);
  else if (view.magnified) view.pan(...way.map((part) => -part * 4 * view.room[0]));
  else if (nearer) view.change((camera) => camera.approach(nearer), event.timeStamp);
  else if (event.shiftKey) view.change((camera) => camera.move(...way), event.timeStamp);
  else view.change((camera) => camera.turn(...way.map((part) => part * Math.PI)), event.timeStamp);
}

const KEYS = {
  r: () => view.whole(true),
  t: () => pointed && trace(pointed),
  z: () => view.magnify(1, hovered),
  Z: () => view.magnify(-1, hovered),
  Escape: () => view.magnify(-Infinity),
  g: () => toggleShow('grid'),
  c: () => toggleShow(shown() || usualCost()),
  b: () => blink(),
  q: () => quit(),
  '?': () => find('help').showModal(),
};

// The keys of the course's program. Where text is typed they are text; a number has no letters, and in a list they act,
// too.
function press(event) {
  const types = event.target.matches('textarea:not([readonly]), input:not([type=checkbox], [type=radio], [type=range], [type=number])');
  const act = KEYS[event.key];
  const isOver = document.body.classList.contains('ended');
  if (types || !act || isOver || event.ctrlKey || event.metaKey || event.altKey || find('help').open) return;
  event.preventDefault();
  act();
}

// Without a grid each ray may be tested against everything, so that pixels differ by their rays alone.
const usualCost = () => (['auto', 'cells'].includes(value('grid')) ? 'tests' : 'rays');

// The pixel under the pointer, with its colour: in a comparison that of both pictures.
function point(pixel) {
  pointed = pixel;
  const object = pixel && objectAt(pixel);
  const parts = pixel ? [`pixel ${pixel.join(' ')}`, ...told(pixel)] : [];
  if (object) parts.push(`${object.name} in line ${object.line}`);
  find('pointed').replaceChildren(...parts.map((part) => {
    const span = document.createElement('span');
    span.append(...[part].flat());
    return span;
  }));
  markObject(object);
}

// What is said about the values of a pixel.
function told(pixel) {
  const colors = toldImages().flatMap(([name, image]) => {
    const color = view.colorIn(image, pixel);
    return color ? [[name, color]] : [];
  });
  const said = colors.map(([name, color]) => {
    const swatch = document.createElement('span');
    swatch.className = 'swatch';
    swatch.style.background = `rgb(${color.join(' ')})`;
    return [swatch, `${name} ${color.join(' ')}`];
  });
  if (colors.length === 2) {
    const [[, one], [, other]] = colors;
    const apart = one.map((level, channel) => Math.abs(level - other[channel]));
    said.push(apart.some((level) => level > 0) ? `apart ${apart.join(' ')}` : 'equal');
  }
  if (view.counts) return [`${grouped(view.counts[pixel[1] * size()[0] + pixel[0]])} ${value('show')}`];
  return said;
}
