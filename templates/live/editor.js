'use strict';
// The scene's text: every pause renders it, and an error stands at its line. Objects in the text and in the picture
// mark each other.

const PAUSE = 350;

const editor = {
  area: find('text'),
  timer: 0,
  // What the parser says: the problem, and perhaps its place and a hint.
  error: null,
  // The object that is marked, and where it stands: [start, end] in the text.
  object: null,
  range: null,
};
// What each pixel shows: { size, objects, places }.
let objectMap = null;

async function editorSends() {
  clearTimeout(editor.timer);
  const text = editor.area.value;
  view.readWith = editionWords();
  try {
    const { meta } = await ask('/scene', { text, words: wordsOf() });
    editor.error = meta.error || null;
    if (meta.scene) view.open(meta.scene);
    else find('taken').textContent = 'The text is not a scene of this edition; “Scene” shows where.';
    if (meta.scene && meta.scene.is_unlit) say('The scene has no lights: its surfaces show their flat colours.');
  } catch (error) {
    complain(error);
  }
  drawMarks();
}

// Where a line and a column, from 1, stand in the text.
function offsetOf(line, column) {
  const text = editor.area.value;
  let at = 0;
  for (let number = 1; number < line; number++) {
    const end = text.indexOf('\n', at);
    if (end < 0) return text.length;
    at = end + 1;
  }
  return Math.min(text.length, at + [...text.slice(at)].slice(0, column - 1).join('').length);
}

// The word at a place: up to white space or a brace, and at least one character.
function wordAt(start) {
  const rest = editor.area.value.slice(start);
  return [start, start + Math.max(1, rest.search(/[\s{}]|$/))];
}

// An object's text, from its keyword to the brace that closes it.
function objectRange({ line, column }) {
  const text = editor.area.value;
  const start = offsetOf(line, column);
  let depth = 0;
  for (let at = start; at < text.length; at++) {
    if (text[at] === '#' || text.startsWith('//', at)) at = (text.indexOf('\n', at) + 1 || text.length) - 1;
    if (text[at] === '{') depth++;
    if (text[at] === '}' && --depth <= 0) return [start, at + 1];
  }
  return [start, text.length];
}

// Lays the marks behind the text, and the messages at their lines.
function drawMarks() {
  const text = editor.area.value;
  const { at } = editor.error || {};
  const spans = at ? [[...wordAt(offsetOf(...at)), 'error']] : [];
  const isFree = ([start, end]) => !spans.some(([from, to]) => from < end && start < to);
  // An error within an object takes its place.
  if (editor.range && isFree(editor.range)) spans.push([...editor.range, 'object']);
  spans.sort((a, b) => a[0] - b[0]);
  const parts = [];
  let done = 0;
  for (const [start, end, kind] of spans) {
    const mark = document.createElement('mark');
    [mark.className, mark.textContent] = [kind, text.slice(start, end) || ' '];
    parts.push(text.slice(done, start), mark);
    done = end;
  }
  find('marks').replaceChildren(...parts, `${text.slice(done)}\n`);
  const count = text.split('\n').length;
  find('lines').replaceChildren(...Array.from({ length: count }, (_, index) => {
    if (!at || index + 1 !== at[0]) return `${index + 1}\n`;
    const mark = document.createElement('mark');
    mark.textContent = `${index + 1}`;
    return [mark, '\n'];
  }).flat());
  editor.area.setAttribute('aria-invalid', `${editor.error !== null}`);
  writeComplaint();
  scrollMarks();
}

function writeComplaint() {
  const { at, problem, hint } = editor.error || {};
  const said = problem ? `${at ? `line ${at[0]}: ` : ''}${problem}${hint ? ` (${hint})` : ''}` : '';
  const message = find('complaint').firstElementChild;
  // What is said already is not said again.
  if (message.textContent !== said) message.textContent = said;
  find('complaint').hidden = !problem;
}

// Selects the word at which the error was found.
function goToError() {
  const { at } = editor.error || {};
  if (!at) return;
  const { area } = editor;
  area.focus();
  area.setSelectionRange(...wordAt(offsetOf(...at)));
  area.scrollTop = topOf(at[0]) - area.clientHeight / 2;
}

const lineHeight = () => parseFloat(getComputedStyle(editor.area).lineHeight);
const topOf = (line) => parseFloat(getComputedStyle(editor.area).paddingTop) + (line - 1) * lineHeight();

// The marks and the numbers follow the text.
function scrollMarks() {
  const { scrollTop, scrollLeft } = editor.area;
  find('marks').style.transform = `translate(${-scrollLeft}px, ${-scrollTop}px)`;
  find('lines').style.transform = `translateY(${-scrollTop}px)`;
}

// The objects that the picture shows, once it rests.
async function lookAround() {
  if (!view.isOpen()) return;
  const scene = view.scene.revision;
  try {
    const { meta, bytes } = await ask('/objects', { view: view.question() });
    if (view.scene.revision !== scene) return;
    objectMap = { ...meta, places: new Uint16Array(bytes.slice().buffer) };
  } catch (error) {
    complain(error);
  }
}

// The object that a pixel shows, if that is known.
function objectAt([x, y]) {
  if (!objectMap || view.stage === 'sketch' || view.sketching) return null;
  const [width, height] = size();
  const [column, row] = [Math.floor((x * objectMap.size[0]) / width), Math.floor((y * objectMap.size[1]) / height)];
  return objectMap.objects[objectMap.places[row * objectMap.size[0] + column] - 1] || null;
}

// Marks an object in the text and in the picture, or none.
function markObject(object) {
  if (object === editor.object) return;
  editor.object = object;
  editor.range = object ? objectRange(object) : null;
  drawMarks();
  drawOverlay();
}

// The innermost object that stands around a place in the text, of those that the picture shows.
function objectAround(place) {
  if (!objectMap) return null;
  const around = objectMap.objects.map((object) => [objectRange(object), object])
    .filter(([[start, end]]) => start <= place && place <= end);
  around.sort(([a], [b]) => b[0] - a[0]);
  return around.length > 0 ? around[0][1] : null;
}

function outlineObject(context) {
  const { object } = editor;
  if (!object || !objectMap || view.stage === 'sketch' || view.sketching) return;
  const { size: [width, height], places, objects } = objectMap;
  const place = objects.indexOf(object) + 1;
  const [across, down] = [view.size[0] / width, view.size[1] / height];
  const is = (x, y) => x >= 0 && y >= 0 && x < width && y < height && places[y * width + x] === place;
  const [left, top, right, bottom] = view.visible([width, height]);
  context.fillStyle = '#ff5fd2';
  for (let y = top; y < bottom; y++) {
    for (let x = left; x < right; x++) {
      const isEdge = is(x, y) && !(is(x - 1, y) && is(x + 1, y) && is(x, y - 1) && is(x, y + 1));
      if (isEdge) context.fillRect(x * across, y * down, Math.max(1.5, across), Math.max(1.5, down));
    }
  }
}

// Puts the camera's block in place of the one in the text.
function keepCamera() {
  const block = /\b(Orthographic|Perspective)Camera\s*\{[^}]*\}\n?/;
  editor.area.value = editor.area.value.replace(block, () => view.camera.block());
  view.camera = null;
  selectTab('editor');
  editorSends();
}

function startEditor(text) {
  const { area } = editor;
  area.value = text;
  area.addEventListener('input', () => {
    drawMarks();
    clearTimeout(editor.timer);
    editor.timer = setTimeout(editorSends, PAUSE);
  });
  area.addEventListener('scroll', scrollMarks);
  area.addEventListener('mousemove', (event) => {
    const line = 1 + Math.floor((event.offsetY + area.scrollTop - topOf(1)) / lineHeight());
    const start = offsetOf(line, 1);
    const indent = area.value.slice(start).search(/[^ \t]/);
    markObject(objectAround(start + Math.max(0, indent)));
  });
  area.addEventListener('mouseleave', () => markObject(null));
  area.addEventListener('keyup', () => markObject(objectAround(area.selectionStart)));
  find('keep').addEventListener('click', keepCamera);
  find('complaint').addEventListener('click', goToError);
  drawMarks();
}
