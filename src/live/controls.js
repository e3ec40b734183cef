'use strict';
// The controls are flags of the command line: their words are made from the form, and the form is filled from words.

const NUMBERED = ['bounces', 'weight', 'seed'];
const SAMPLES = ['-random_samples', '-uniform_samples', '-jittered_samples', '-adaptive_samples'];
const FILTERS = ['-box_filter', '-tent_filter', '-gaussian_filter', '-mitchell_filter'];
const FINER = [[16, 8], [64, 3], [256, 1]];

const value = (id) => find(id).value.trim();
const size = () => [Number(value('width')), Number(value('height'))];

// The flags. Those of the samples can be replaced.
function wordsOf(samples = sampleWords()) {
  const words = ['-size', value('width'), value('height')];
  if (value('shadows')) words.push(value('shadows'));
  if (find('shade_back').checked) words.push('-shade_back');
  if (Number(value('bounces')) !== 0) words.push('-bounces', value('bounces'));
  if (Number(value('weight')) !== 0) words.push('-weight', value('weight'));
  words.push(...samples);
  if (value('seed')) words.push('-seed', value('seed'));
  if (value('filter')) words.push(value('filter'), value('radius'));
  return [...words, ...gridWords()];
}

function sampleWords() {
  const kind = value('samples');
  if (!kind) return [];
  return kind === '-adaptive_samples' ? [kind, value('count'), value('error')] : [kind, value('count')];
}

function gridWords() {
  const shows = value('show') === 'grid';
  const kind = value('grid') || (shows ? 'auto' : '');
  if (!kind || (shows && kind === 'none')) return shows ? ['-grid', 'auto', '-visualize_grid'] : [];
  const words = kind === 'cells' ? ['-grid', value('nx'), value('ny'), value('nz')] : ['-grid', kind];
  return shows ? [...words, '-visualize_grid'] : words;
}

// Fills the form from flags with their values.
function fillControls(words) {
  const set = (id, to) => { find(id).value = to; };
  const next = () => words[++at];
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
  find('count').disabled = !value('samples');
  find('error').disabled = value('samples') !== '-adaptive_samples';
  find('seed').disabled = !value('samples');
  find('radius').disabled = !value('filter');
  find('refine').disabled = value('samples') !== '';
  for (const id of ['nx', 'ny', 'nz']) find(id).disabled = value('grid') !== 'cells';
}

// Whether a picture gets more samples while the hand rests.
const refines = () => find('refine').checked && !find('refine').disabled && value('show') === 'color';

// What a picture shows, as the program names it.
const shown = () => (value('show') === 'grid' ? 'color' : value('show'));

// Shows something else, or the colours again.
function toggleShow(kind) {
  find('show').value = value('show') === kind ? 'color' : kind;
  controlsChanged();
}

function startControls() {
  find('controls').addEventListener('submit', (event) => event.preventDefault());
  find('controls').addEventListener('input', () => {
    enableControls();
    if (find('controls').checkValidity()) controlsChanged();
  });
}

function controlsChanged() {
  find('costs').hidden = true;
  view.layout();
  view.rest();
}
