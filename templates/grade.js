'use strict';
// A click on a cell whose picture differs shows the picture (A), the reference (B), their amplified difference, and
// a fourth one that blinks between the first two.
const files = JSON.parse(document.getElementById('pictures').textContent);
const dialog = document.querySelector('dialog');
const [canvasA, canvasB, canvasDifference, canvasBlink] = dialog.querySelectorAll('canvas');
const [, , captionDifference, captionBlink] = dialog.querySelectorAll('figcaption');
const stop = dialog.querySelector('figure button');
const INTERVAL = 500;
let timer = 0;

async function draw(canvas, index) {
  const image = new Image();
  image.src = 'data:image/png;base64,' + files[index];
  await image.decode();
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

// The largest power of two with which no difference leaves the range of a byte.
function amplification(differences) {
  const largest = differences.reduce((a, b) => Math.max(a, b), 0);
  let factor = 1;
  while (largest > 0 && 2 * factor * largest < 256) factor *= 2;
  return factor;
}

function drawDifference(a, b) {
  const differences = a.data.map((level, at) => (at % 4 === 3 ? 0 : Math.abs(level - b.data[at])));
  const factor = amplification(differences);
  const shown = new ImageData(differences.map((level, at) => (at % 4 === 3 ? 255 : factor * level)), a.width);
  [canvasDifference.width, canvasDifference.height] = [a.width, a.height];
  canvasDifference.getContext('2d').putImageData(shown, 0, 0);
  captionDifference.textContent = 'Difference, times ' + factor;
}

function blink(a, b) {
  [canvasBlink.width, canvasBlink.height] = [a.width, a.height];
  let isA = false;
  const turn = () => {
    isA = !isA;
    canvasBlink.getContext('2d').putImageData(isA ? a : b, 0, 0);
    captionBlink.textContent = isA ? 'Now A' : 'Now B';
  };
  turn();
  const start = () => {
    timer = setInterval(turn, INTERVAL);
    stop.textContent = 'Stop';
  };
  stop.onclick = () => {
    if (timer === 0) return start();
    clearInterval(timer);
    timer = 0;
    stop.textContent = 'Blink';
  };
  start();
}

async function show(cell) {
  const name = cell.parentElement.querySelector('th').firstChild;
  const cause = cell.querySelector('small');
  dialog.querySelector('h2').textContent = name ? name.textContent : '';
  dialog.querySelector('p').textContent = cell.title + (cause ? '\nCause: ' + cause.textContent : '');
  const a = await draw(canvasA, cell.dataset.a);
  const b = await draw(canvasB, cell.dataset.b);
  drawDifference(a, b);
  clearInterval(timer);
  blink(a, b);
  if (!dialog.open) dialog.showModal();
}

dialog.addEventListener('close', () => {
  clearInterval(timer);
  timer = 0;
});
document.querySelector('table').addEventListener('click', (event) => {
  const cell = event.target.closest('td[data-a]');
  if (cell) show(cell);
});
