'use strict';
// A picture from elsewhere, compared with what is shown: the block, the cause, the difference, and both in turn.

const BLINK = 500;

const compared = {
  // The file: { name, size }.
  file: null,
  // What was compared last: the pixels of the file, of this program's picture, and of their difference.
  images: null,
  timer: 0,
};

// Costs and the grid's cells are no colours that could be compared.
const comparing = () => compared.file !== null && value('show') === 'color';
const look = () => document.querySelector('input[name=look]:checked').value;

// Takes a file as the reference, and gives the picture its size.
async function takeFile(file) {
  selectTab('compare');
  try {
    const name = file.name.replace(/[^\w.-]/g, '_');
    const { meta } = await ask(`/reference?name=${name}`, file);
    takeReference(meta, file.name);
    setSize(meta.size);
    find('show').value = 'color';
    if (sayWhatIsWrong()) controlsChanged();
    else say('The picture is larger than this page shows.');
  } catch (error) {
    complain(error);
  }
}

function takeReference(file, name) {
  compared.file = file;
  find('reference-name').textContent = file ? `${name}, ${file.size.join(' × ')} pixels` : '';
  for (const id of ['looks', 'comparison']) find(id).hidden = !file;
  if (!file) {
    stopBlinking();
    showLargest(null);
  }
}

// Compares the file with the picture that is shown, and looks for the cause of a difference.
async function compareLive() {
  const question = { view: view.question() };
  find('cause').textContent = '';
  showLargest(null);
  // Those of the last comparison may be of another view.
  compared.images = null;
  const { meta, bytes } = await ask('/compare', question);
  if (!comparing()) return;
  const [width, height] = meta.size;
  const image = (place) => new ImageData(bytes.slice(place * width * height * 4, (place + 1) * width * height * 4), width);
  compared.images = { reference: image(0), own: image(1), difference: image(2) };
  find('comparison').textContent = groupedIn(meta.block);
  find('amplified').textContent = `× ${meta.amplification}`;
  showLargest(meta.largest);
  showLook();
  status(`compared, ${meta.size.join(' × ')}`);
  if (!meta.largest) {
    find('cause').textContent = 'The pictures are equal.';
    return;
  }
  find('cause').textContent = 'looking for the cause …';
  const found = await ask('/cause', question);
  find('cause').textContent = found.meta.cause ? `cause: ${found.meta.cause}` : 'No cause can be searched for here.';
}

// Offers the pixel with the largest difference, if there is one.
function showLargest(largest) {
  const button = find('largest');
  button.hidden = !largest;
  if (!largest) return;
  button.textContent = `Trace pixel ${largest.at.join(' ')}, which differs most: by ${largest.levels} levels`;
  button.onclick = () => {
    point(largest.at);
    trace(largest.at);
  };
}

// Shows the picture, the file, their difference, or both side by side.
function showLook(kind = look()) {
  const { images } = compared;
  if (!images || view.sketching || !comparing()) return;
  if (kind !== 'slider') {
    view.show(images[kind]);
    return drawOverlay();
  }
  const both = new ImageData(images.own.data.slice(), images.own.width);
  const left = divider();
  for (let row = 0; row < both.height; row++) {
    const start = row * both.width * 4;
    both.data.set(images.reference.data.subarray(start, start + left * 4), start);
  }
  view.show(both);
  drawOverlay();
}

// The column of the picture from which on the file is not shown; 0 where both are not side by side.
const divider = () => (comparing() && compared.images && look() === 'slider'
  ? Math.round((find('slider').value / 1000) * compared.images.own.width) : 0);

function drawDivider(context) {
  const left = divider();
  if (left === 0 || view.stage === 'sketch') return;
  const x = left * (view.size[0] / size()[0]);
  for (const [color, from, wide] of [['#000', -1.5, 3], ['#fff', -0.5, 1]]) {
    context.fillStyle = color;
    context.fillRect(x + from, 0, wide, view.size[1]);
  }
}

// The images whose pixels are told of: [name, image]. In a comparison these are both.
function toldImages() {
  const { images } = compared;
  if (comparing() && images && view.stage !== 'sketch') return [['file', images.reference], ['here', images.own]];
  return view.image ? [['colour', view.image]] : [];
}

// Shows the file and the picture in turn.
function blink() {
  if (compared.timer) return stopBlinking();
  if (!compared.images || !comparing()) return say('There is no picture to blink with: drop one in.');
  let isFile = false;
  compared.timer = setInterval(() => {
    isFile = !isFile;
    showLook(isFile ? 'reference' : 'own');
    find('blink').firstChild.textContent = isFile ? 'The file ' : 'This picture ';
  }, BLINK);
  find('blink').setAttribute('aria-pressed', 'true');
}

function stopBlinking() {
  clearInterval(compared.timer);
  compared.timer = 0;
  find('blink').setAttribute('aria-pressed', 'false');
  find('blink').firstChild.textContent = 'Blink ';
  if (comparing()) showLook();
}

function startCompare(file) {
  if (file) takeReference(file, file.name);
  find('file').addEventListener('change', (event) => event.target.files[0] && takeFile(event.target.files[0]));
  for (const kind of ['dragover', 'drop']) {
    document.addEventListener(kind, (event) => {
      event.preventDefault();
      const [dropped] = kind === 'drop' ? event.dataTransfer.files : [];
      if (dropped) takeFile(dropped);
    });
  }
  find('looks').addEventListener('input', () => {
    stopBlinking();
    showLook();
  });
  find('slider').addEventListener('input', () => {
    document.querySelector('input[value=slider]').checked = true;
    showLook('slider');
  });
  find('blink').addEventListener('click', blink);
  find('forget').addEventListener('click', () => {
    compared.images = null;
    takeReference(null, '');
    find('cause').textContent = '';
    view.rest();
  });
}
