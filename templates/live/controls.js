'use strict';
// The controls are flags of the command line: their words are made from the form, and the form is filled from words.

const NUMBERED = ['bounces', 'weight', 'seed'];
const DEFAULTED = ['bounces', 'weight'];
const SAMPLES = ['-random_samples', '-uniform_samples', '-jittered_samples', '-sobol_samples', '-adaptive_samples'];
const FILTERS = ['-box_filter', '-tent_filter', '-gaussian_filter', '-mitchell_filter'];
const FINER = [[16, 8], [64, 3], [256, 1]];

// What a field says, or has said before if that is not valid.
const lastValid = {};
function value(id) {
  const field = find(id);
  if (!field.matches(':invalid')) lastValid[id] = field.value.trim();
  return lastValid[id] ?? field.defaultValue;
}
// Width and height of the picture: what displaced samples enlarge, the blur reduces.
function size() {
  const [enlarged, reduced] = [value('samples') === '-jitter', value('filter') === '-filter'];
  const changes = enlarged !== reduced && value('edition') !== '2019';
  return ['width', 'height'].map((side) => {
    const pixels = Number(value(side));
    return changes ? Math.max(1, Math.floor(enlarged ? pixels * 3 : pixels / 3)) : pixels;
  });
}

// Gives the picture this width and height, which the samples and the filter may change.
function setSize(wanted) {
  for (const factor of [3, 1 / 3, 1]) {
    [find('width').value, find('height').value] = wanted.map((side) => Math.floor(side * factor));
    if (size().join() === wanted.join()) return;
  }
}

// The flags. Those of the samples can be replaced.
function wordsOf(samples = sampleWords()) {
  const words = ['-size', value('width'), value('height')];
  if (value('edition')) words.push('-edition', value('edition'));
  if (value('shadows')) words.push(value('shadows'));
  if (find('shade_back').checked) words.push('-shade_back');
  for (const name of DEFAULTED) {
    if (value(name) !== '') words.push(`-${name}`, value(name));
  }
  words.push(...samples);
  if (value('seed') && value('samples') !== '-jitter') words.push('-seed', value('seed'));
  if (value('filter')) words.push(value('filter'));
  if (FILTERS.includes(value('filter'))) words.push(value('radius'));
  return [...words, ...gridWords()];
}

function sampleWords() {
  const kind = value('samples');
  if (!kind) return [];
  if (kind === '-jitter') return [kind];
  // Aalto's samples in a grid have a flag of their own.
  if (kind === '-uniform_samples' && value('edition') === 'aalto') return ['-regular_samples', value('count')];
  return kind === '-adaptive_samples' ? [kind, value('count'), value('error')] : [kind, value('count')];
}

function gridWords() {
  const shows = value('show') === 'grid';
  const kind = value('grid') || (shows ? 'auto' : '');
  if (!kind || (shows && kind === 'none')) return shows ? ['-grid', 'auto', '-visualize_grid'] : [];
  const words = kind === 'cells' ? ['-grid', value('nx'), value('ny'), value('nz')] : ['-grid', kind];
  return shows ? [...words, '-visualize_grid'] : words;
}

// The flags on which it depends in which edition the scene is read.
const editionWords = () => [value('edition'), ...['samples', 'filter'].map(value).filter((flag) => /^-(jitter|filter)$/.test(flag))].join(' ');

// Fills the form from flags with their values.
function fillControls(words) {
  const set = (id, to) => { find(id).value = to; };
  const next = () => words[++at];
  if (words.includes('-edition')) set('edition', words[words.indexOf('-edition') + 1]);
  const isOfAalto = value('edition') === 'aalto';
  let at = 0;
  for (; at < words.length; at++) {
    const flag = words[at];
    if (flag === '-size') [set('width', next()), set('height', next())];
    if (flag === '-shadows' && value('shadows') === '') set('shadows', flag);
    if (flag === '-transparent_shadows') set('shadows', flag);
    if (flag === '-shade_back') find('shade_back').checked = true;
    if (flag === '-visualize_grid') set('show', 'grid');
    if (NUMBERED.includes(flag.slice(1))) set(flag.slice(1), next());
    if (SAMPLES.includes(flag)) [set('samples', flag), set('count', next())];
    if (flag === '-adaptive_samples') set('error', next());
    if (flag === '-uniform_samples' && isOfAalto) set('samples', '-random_samples');
    if (flag === '-regular_samples') [set('edition', 'aalto'), set('samples', '-uniform_samples'), set('count', next())];
    if (flag === '-jitter') set('samples', flag);
    if (flag === '-filter') set('filter', flag);
    if (FILTERS.includes(flag)) [set('filter', flag), set('radius', next())];
    if (flag === '-grid' && /^(auto|none)$/.test(words[at + 1])) set('grid', next());
    else if (flag === '-grid') {
      set('grid', 'cells');
      for (const id of ['nx', 'ny', 'nz']) set(id, next());
    }
  }
  enableControls();
}

// Only what has a meaning can be set.
function enableControls() {
  find('count').disabled = !SAMPLES.includes(value('samples'));
  find('error').disabled = value('samples') !== '-adaptive_samples';
  find('seed').disabled = !SAMPLES.includes(value('samples'));
  find('radius').disabled = !FILTERS.includes(value('filter'));
  find('refine').disabled = value('samples') !== '';
  for (const id of ['nx', 'ny', 'nz']) find(id).disabled = value('grid') !== 'cells';
}

// Whether a picture gets more samples while the hand rests.
const refines = () => find('refine').checked && !find('refine').disabled && value('show') === 'color';

// The cost that a picture shows; null if it shows colours.
const shown = () => (['color', 'grid'].includes(value('show')) ? null : value('show'));

// Shows something else, or the colours again.
function toggleShow(kind) {
  find('show').value = value('show') === kind ? 'color' : kind;
  controlsChanged();
}

// Says which numbers are none, or outside their limits, and whether all are right.
function sayWhatIsWrong() {
  const wrong = [...find('controls').querySelectorAll(':invalid')].filter((field) => field.matches('input'));
  const limits = ({ min, max }) => (max ? `between ${min} and ${max}` : `of at least ${min}`);
  const lines = wrong.map((field) => {
    const [name, kind] = [field.labels[0].firstChild.textContent.trim(), field.step === 'any' ? 'number' : 'whole number'];
    field.setAttribute('aria-invalid', 'true');
    return `${name}: a ${kind} ${limits(field)} is needed.`;
  });
  for (const field of find('controls').querySelectorAll('input:valid')) field.removeAttribute('aria-invalid');
  // What is said already is not said again.
  if (find('wrong').textContent !== lines.join('\n')) find('wrong').textContent = lines.join('\n');
  find('wrong').hidden = lines.length === 0;
  return lines.length === 0;
}

// The command line may ask for more than a page would.
function setLimits({ side, samples, bounces, support }) {
  for (const [id, most] of [['width', side], ['height', side], ['count', samples], ['bounces', bounces], ['radius', support]]) {
    find(id).max = most;
  }
}

// The colours of the cells, by the number of primitives in them.
function showCellColors(colors) {
  find('cells').replaceChildren(...colors.map((color, place) => {
    const [item, swatch] = [document.createElement('li'), document.createElement('span')];
    swatch.className = 'swatch';
    swatch.style.background = `rgb(${color.join(' ')})`;
    item.append(swatch, `${place + 1}${place + 1 === colors.length ? ' or more' : ''}`);
    return item;
  }));
  const title = document.createElement('li');
  title.textContent = 'Primitives in a cell:';
  find('cells').prepend(title);
}

function startControls() {
  find('controls').addEventListener('submit', (event) => event.preventDefault());
  find('controls').addEventListener('input', () => {
    enableControls();
    if (sayWhatIsWrong()) controlsChanged();
  });
}

// Shows the edition in which a scene is read, and why, and what goes without a flag there.
function showEdition({ note, defaults }) {
  find('taken').textContent = note || '';
  for (const name of DEFAULTED) find(name).placeholder = defaults[name];
}

function controlsChanged() {
  find('costs').hidden = true;
  find('cells').hidden = value('show') !== 'grid';
  view.layout();
  if (view.scene && view.readWith !== editionWords()) return editorSends();
  view.rest();
}
