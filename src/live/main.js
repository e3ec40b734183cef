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

function startTabs() {
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
  selectTab('controls');
}

async function quit() {
  try {
    await ask('/quit');
  } catch {
    // The answer has no description; the program ends.
  }
  view.scene = null;
  status('The program has ended.');
  document.body.classList.add('ended');
}

async function save() {
  try {
    say((await ask('/save', { ...view.question(), show: 'color' })).meta.said);
  } catch (error) {
    complain(error);
  }
}

// Copies a field, by the old way where the page is not on this machine's own name.
async function copy(field) {
  field.select();
  if (navigator.clipboard) await navigator.clipboard.writeText(field.value).catch(() => document.execCommand('copy'));
  else document.execCommand('copy');
  say('Copied.');
}

function startButtons(outputs) {
  find('save').title = outputs.length > 0 ? `writes ${outputs.join(', ')}` : 'the command line names no picture';
  find('save').disabled = outputs.length === 0;
  find('save').addEventListener('click', save);
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
  fillControls(meta.words);
  startTabs();
  startButtons(meta.outputs);
  startControls();
  startHand();
  startRays();
  startEditor(meta.text);
  startCompare(meta.reference);
  view.open(meta.scene);
  window.addEventListener('resize', () => view.layout());
}

start().catch(complain);
