'use strict';
// Starts the page: panels, buttons, and the first picture.

const tabs = [...document.querySelectorAll('[role=tab]')];

function selectTab(panel) {
  for (const tab of tabs) {
    const isIt = tab.getAttribute('aria-controls') === panel;
    tab.setAttribute('aria-selected', `${isIt}`);
    tab.tabIndex = isIt ? 0 : -1;
    find(tab.getAttribute('aria-controls')).hidden = !isIt;
  }
  if (panel === 'editor') drawMarks();
}

function startTabs(first) {
  for (const [place, tab] of tabs.entries()) {
    tab.addEventListener('click', () => selectTab(tab.getAttribute('aria-controls')));
    tab.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const next = tabs[(place + step + tabs.length) % tabs.length];
      selectTab(next.getAttribute('aria-controls'));
      next.focus();
    });
  }
  selectTab(first);
}

async function quit() {
  ending.abort();
  try {
    await ask('/quit');
  } catch {
    // The answer has no description; the program ends.
  }
  status('');
  showOver('The program has ended.');
}

// Writes the pictures of the command line, or downloads the one that is shown if there are none.
async function save(outputs) {
  if (outputs.length === 0) return download();
  try {
    say((await ask('/save', { view: view.question() })).meta.said);
  } catch (error) {
    complain(error);
  }
}

function download() {
  if (view.stage === '' || view.stage === 'sketch') return say('The picture is not finished yet.');
  view.canvas.toBlob((file) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(file);
    link.download = `${find('name').textContent.replace(/^.*[\\/]/, '').replace(/\.[^.]*$/, '') || 'picture'}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    say(`Downloaded as ${link.download}.`);
  }, 'image/png');
}

// Copies a field, by the old way where the page is not on this machine's own name.
async function copy(field) {
  field.select();
  if (navigator.clipboard) await navigator.clipboard.writeText(field.value).catch(() => document.execCommand('copy'));
  else document.execCommand('copy');
  say('Copied.');
}

function startButtons(outputs) {
  find('save').title = outputs.length > 0 ? `writes ${outputs.join(', ')}` : 'downloads the picture that is shown as PNG';
  find('save').addEventListener('click', () => save(outputs));
  find('quit').addEventListener('click', quit);
  find('help-button').addEventListener('click', KEYS['?']);
  find('home').addEventListener('click', () => {
    view.camera = null;
    view.layout();
    view.rest();
  });
  for (const button of document.querySelectorAll('[data-copy]')) {
    button.addEventListener('click', () => copy(find(button.dataset.copy)));
  }
}

async function start() {
  const { meta } = await ask('/start');
  find('name').textContent = meta.name;
  document.title = `${meta.name} · raytracer`;
  setLimits(meta.most);
  fillControls(meta.words);
  if (meta.reference) setSize(meta.reference.size);
  view.openedWith = view.readWith = editionWords();
  showCellColors(meta.cell_colors);
  // The cause of a difference is told beside the comparison.
  startTabs(meta.reference ? 'compare' : 'controls');
  startButtons(meta.outputs);
  startControls();
  startHand();
  startRays();
  startEditor(meta.text);
  startCompare(meta.reference);
  find('cells').hidden = value('show') !== 'grid';
  view.open(meta.scene);
  listen();
  window.addEventListener('resize', () => view.layout());
}

start().catch(complain);
