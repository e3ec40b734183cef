'use strict';
// The hand: mouse, touch and wheel on the picture, and the keys.

// The fingers or buttons that are down, by their pointers' ids.
const held = new Map();
let pointed = null;

const longerSide = () => Math.max(...view.size);

function dragged(event, before) {
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
    point(view.pixelAt(event.clientX, event.clientY));
    const before = held.get(event.pointerId);
    if (!before) return;
    dragged(event, before);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY, button: before.button });
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, (event) => held.delete(event.pointerId));
  }
  canvas.addEventListener('pointerleave', () => point(null));
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('auxclick', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    view.change((camera) => camera.approach(Math.exp(0.12 * lines)), event.timeStamp);
  }, { passive: false });
  canvas.addEventListener('keydown', steer);
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
  if (nearer) view.change((camera) => camera.approach(nearer), event.timeStamp);
  else if (event.shiftKey) view.change((camera) => camera.move(...way), event.timeStamp);
  else view.change((camera) => camera.turn(...way.map((part) => part * Math.PI)), event.timeStamp);
}

const KEYS = {
  r: () => view.whole(true),
  t: () => pointed && trace(pointed),
  g: () => toggleShow('grid'),
  c: () => toggleShow(lastCost()),
  b: () => blink(),
  q: () => quit(),
  '?': () => find('help').showModal(),
};

// The keys of the course's program. Where text is typed they are text.
function press(event) {
  const types = event.target.matches('textarea:not([readonly]), input:not([type=checkbox], [type=radio], [type=range]), select');
  const act = KEYS[event.key];
  if (types || !act || event.ctrlKey || event.metaKey || event.altKey || find('help').open) return;
  event.preventDefault();
  act();
}

// The cost that was shown last, or tests.
let costShown = 'tests';
function lastCost() {
  if (['rays', 'tests', 'cells'].includes(value('show'))) costShown = value('show');
  return costShown;
}

// The pixel under the pointer.
function point(pixel) {
  pointed = pixel;
  const object = pixel && objectAt(pixel);
  const named = object ? `, ${object.name} in line ${object.line}` : '';
  find('pointed').textContent = pixel ? `pixel ${pixel.join(' ')}${named}` : '\u00a0';
  markObject(object);
}
