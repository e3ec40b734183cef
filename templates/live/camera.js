'use strict';
// The camera: how the hand moves it, where it shows a point, and its block of scene text.

const add = (a, b) => a.map((x, i) => x + b[i]);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const scaled = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => scaled(a, 1 / (length(a) || 1));

// Rotates v about a unit axis (Rodrigues).
function rotated(v, axis, angle) {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scaled(v, cosine), scaled(cross(axis, v), sine)), scaled(axis, dot(axis, v) * (1 - cosine)));
}

// Rounds to the fewest decimals whose last place is no larger than a step.
const roundedTo = (step, x) => Number(x.toFixed(Math.max(0, Math.min(100, Math.ceil(-Math.log10(step))))));

class Camera {
  // From the program's description of a camera. The pivot is the point about which it turns.
  constructor(described, pivot) {
    Object.assign(this, described);
    this.pivot = pivot;
  }

  // Up is as written or across the direction, as the scene's edition has it.
  axes() {
    const direction = unit(this.direction);
    const right = unit(cross(direction, this.up));
    return { direction, right, up: this.up_as_written ? this.up : cross(right, direction) };
  }

  // How far a point is from the camera along each axis.
  along(point) {
    const { direction, right, up } = this.axes();
    const offset = subtract(point, this.center);
    const across = cross(right, direction);
    const upward = dot(offset, across) / dot(up, across);
    return { rightward: dot(offset, right), upward, depth: dot(offset, direction) - upward * dot(up, direction) };
  }

  // The length that the longer side of the picture spans at this distance.
  span(distance) {
    if (this.kind === 'orthographic') return this.size;
    return 2 * Math.tan((this.angle * Math.PI) / 360) * distance;
  }

  // The lengths that one pixel of the picture spans at this distance, across and down.
  pixelAt(distance) {
    const spanned = this.is_stretched ? size().map((side) => Math.max(1, side - 1)) : [Math.max(...size()), Math.max(...size())];
    return spanned.map((side) => this.span(distance) / side);
  }

  // Turns about the pivot, level with `up`, and never over the poles.
  turn(across, down) {
    const up = unit(this.up);
    const { direction, right } = this.axes();
    const margin = 0.02;
    const tilt = Math.acos(Math.max(-1, Math.min(1, dot(up, direction))));
    const pitch = Math.max(margin - tilt, Math.min(Math.PI - margin - tilt, down));
    const both = (v) => rotated(rotated(v, right, -pitch), up, -across);
    this.center = add(this.pivot, both(subtract(this.center, this.pivot)));
    this.direction = both(direction);
  }

  // Moves sideways, in parts of the picture's longer side.
  move(across, down) {
    const { direction, right, up } = this.axes();
    const distance = Math.abs(dot(subtract(this.pivot, this.center), direction)) || 1;
    const [wide, high] = this.pixelAt(distance).map((side) => side * Math.max(...size()));
    const step = add(scaled(right, -across * wide), scaled(up, down * high));
    this.center = add(this.center, step);
    this.pivot = add(this.pivot, step);
  }

  // Brings the pivot to this part of its distance.
  approach(factor) {
    if (this.kind === 'orthographic') {
      this.size *= factor;
    } else {
      this.center = add(this.pivot, scaled(subtract(this.center, this.pivot), factor));
    }
  }

  // Where a picture of this size shows a point, and how far in front of the camera it is.
  project(point, [width, height]) {
    const { rightward, upward, depth } = this.along(point);
    const [[wide, high], [columns, rows]] = [this.pixelAt(depth), size()];
    const [x, y] = [(rightward / wide / columns) * width, (upward / high / rows) * height];
    return { x: width / 2 + x, y: height / 2 - y, depth };
  }

  // Rounds what the hand moves to the decimals that show: the picture moves by less than a hundredth of a pixel, and its
  // camera is the one that is shown.
  round() {
    const distance = length(subtract(this.pivot, this.center)) || 1;
    const step = Math.min(...this.pixelAt(distance)) / 100;
    this.center = this.center.map((x) => roundedTo(step, x));
    this.direction = this.direction.map((x) => roundedTo(step / distance, x));
    if (this.kind === 'orthographic') this.size = roundedTo(step, this.size);
  }

  block() {
    const kind = this.kind === 'orthographic' ? 'Orthographic' : 'Perspective';
    const last = this.kind === 'orthographic' ? `size ${this.size}` : `angle ${this.angle}`;
    const line = (name) => `    ${name} ${this[name].join(' ')}\n`;
    return `${kind}Camera {\n${line('center')}${line('direction')}${line('up')}    ${last}\n}\n`;
  }
}

// The middle of the scene, or a point in front of the camera where the scene has no bounds.
function pivotOf(camera, bounds) {
  if (bounds) return scaled(add(bounds.min, bounds.max), 0.5);
  const direction = unit(camera.direction);
  const distance = -dot(camera.center, direction);
  return add(camera.center, scaled(direction, distance > 0 ? distance : 5));
}
