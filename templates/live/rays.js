'use strict';
// The rays behind a pixel: drawn into the scene, which may turn under them, and told of in a text whose lines light
// them up.

const COLORS = {
  camera: '#ffffff', light: '#ffd84a', shadow: '#ff7a59', reflected: '#5ad1ff', refracted: '#7dff8a', normal: '#e7a6ff',
};

// What is drawn over the picture.
const traced = { rays: null, pixel: null, lit: null };

async function trace(pixel) {
  selectTab('rays');
  [find('column').value, find('row').value] = pixel;
  try {
    const { meta } = await ask('/trace', { view: view.question(), pixel });
    [traced.rays, traced.pixel, traced.lit] = [meta.rays, meta.pixel, null];
    writeTree();
  } catch (error) {
    complain(error);
  }
  drawOverlay();
}

function clearRays() {
  [traced.rays, traced.pixel, traced.lit] = [null, null, null];
  writeTree();
  drawOverlay();
}

// Writes the lines of the text. One about a ray lights it up.
function writeTree() {
  const rays = traced.rays || { text: [], segments_of_lines: [] };
  const lines = rays.text.map((text, index) => {
    const line = document.createElement('li');
    line.textContent = text;
    line.style.setProperty('--indent', `${text.search(/\S|$/)}ch`);
    const ray = rays.segments_of_lines[index];
    if (ray === null || ray >= rays.segments.length) return line;
    line.className = rays.segments[ray].kind;
    if (rays.segments_of_lines[index - 1] !== ray) line.tabIndex = 0;
    line.dataset.ray = ray;
    return line;
  });
  find('tree').replaceChildren(...lines);
  find('no-rays').hidden = lines.length > 0;
}

function lightRay(event) {
  const line = event.target.closest('[data-ray]');
  const ray = line && event.type !== 'mouseleave' && event.type !== 'focusout' ? Number(line.dataset.ray) : null;
  if (ray === traced.lit) return;
  traced.lit = ray;
  for (const other of find('tree').children) other.classList.toggle('lit', ray !== null && other.dataset.ray === `${ray}`);
  drawOverlay();
}

// Draws the grid of enlarged pixels, the rays, the cells that they pass and the outline of an object over the picture.
function drawOverlay() {
  const overlay = find('overlay');
  const [width, height] = view.room;
  const zoom = window.devicePixelRatio || 1;
  [overlay.width, overlay.height] = [width, height].map((side) => Math.max(1, Math.round(side * zoom)));
  [overlay.style.width, overlay.style.height] = [`${width}px`, `${height}px`];
  if (!view.scene) return;
  const context = overlay.getContext('2d');
  context.scale(zoom, zoom);
  context.translate(...view.origin);
  drawPixels(context);
  drawDivider(context);
  outlineObject(context);
  if (!traced.rays) return;
  const camera = view.seenWith();
  const line = (from, to) => drawLine(context, camera, from, to);
  if (find('show-cells').checked) drawCells(context, line);
  traced.rays.segments.forEach(({ kind, from, to }, index) => {
    const isLit = index === traced.lit;
    context.setLineDash(kind === 'shadow' ? [5, 4] : []);
    // Dark beneath and bright above, so that a line shows on any picture.
    for (const [color, wider] of [['rgb(0 0 0 / .65)', 2], [COLORS[kind], 0]]) {
      context.strokeStyle = color;
      context.lineWidth = (isLit ? 4 : 1.5) + wider;
      context.globalAlpha = traced.lit === null || isLit ? 1 : 0.35;
      line(from, to);
    }
    context.globalAlpha = 1;
    // Seen with the camera that it starts at, a camera ray is a point.
    if (kind === 'camera') drawMark(context, camera, to, isLit);
  });
}

function drawMark(context, camera, at, isLit) {
  const { x, y, depth } = camera.project(at, view.size);
  if (depth <= 0) return;
  context.setLineDash([]);
  for (const [color, wide] of [['rgb(0 0 0 / .65)', 4], [COLORS.camera, 2]]) {
    context.strokeStyle = color;
    context.lineWidth = wide;
    context.beginPath();
    context.arc(x, y, isLit ? 9 : 6, 0, 2 * Math.PI);
    context.stroke();
  }
}

// A line in space, as far as it is in front of the camera.
function drawLine(context, camera, from, to) {
  const depth = (point) => camera.along(point).depth;
  const nearest = camera.kind === 'orthographic' ? -Infinity : 1e-3 * length(subtract(camera.pivot, camera.center));
  let [a, b] = [from, to];
  const [near, far] = [depth(a), depth(b)];
  if (near < nearest && far < nearest) return;
  const cut = () => add(from, scaled(subtract(to, from), (nearest - near) / (far - near)));
  if (near < nearest) a = cut();
  if (far < nearest) b = cut();
  const [start, end] = [a, b].map((point) => camera.project(point, view.size));
  context.beginPath();
  context.moveTo(start.x, start.y);
  context.lineTo(end.x, end.y);
  context.stroke();
}

// The twelve edges of each cell, as pairs of corners; bit 0 of a corner is x, bit 1 y, bit 2 z.
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((corner) =>
  [1, 2, 4].filter((axis) => !(corner & axis)).map((axis) => [corner, corner | axis]));

function drawCells(context, line) {
  const { cells, cell_size: sides } = traced.rays;
  [context.strokeStyle, context.lineWidth] = ['rgb(255 255 255 / .35)', 1];
  for (const cell of cells) {
    const corner = (bits) => cell.map((low, axis) => low + ((bits >> axis) & 1) * sides[axis]);
    for (const [from, to] of EDGES) line(corner(from), corner(to));
  }
}

function startRays() {
  const tree = find('tree');
  for (const kind of ['mouseover', 'mouseleave', 'focusin', 'focusout']) tree.addEventListener(kind, lightRay);
  find('tracing').addEventListener('submit', (event) => {
    event.preventDefault();
    trace([Number(value('column')), Number(value('row'))]);
  });
  find('untrace').addEventListener('click', clearRays);
  find('show-cells').addEventListener('change', () => {
    if (find('show-cells').checked && traced.rays && traced.rays.cells.length === 0) {
      say('There is no grid: choose one in Controls, and trace again.');
    }
    drawOverlay();
  });
}
