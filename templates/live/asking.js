'use strict';
// Questions to the program. Every answer is a description in JSON and the bytes that it describes.

const key = new URLSearchParams(location.search).get('key') || '';

const find = (id) => document.getElementById(id);

class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

// The kinds of questions of which the page needs the last answer only.
const KINDS = {
  '/picture': 'picture', '/compare': 'picture', '/cause': 'picture',
  '/scene': 'scene', '/objects': 'objects', '/trace': 'trace',
};
// Ends the last question of each kind.
const asked = {};

// Asks, and returns { meta, bytes }. A refusal is thrown, with its status and its reason. A later question of its kind
// closes its connection, which ends the work for it.
async function ask(path, question = {}) {
  const kind = KINDS[path];
  const asking = new AbortController();
  if (asked[kind]) asked[kind].abort();
  if (kind) asked[kind] = asking;
  const body = question instanceof Blob ? question : JSON.stringify(question);
  const request = { method: 'POST', headers: { 'X-Key': key }, body, cache: 'no-store', signal: asking.signal };
  let answer;
  let buffer;
  try {
    answer = await fetch(path, request);
    buffer = await answer.arrayBuffer();
  } catch {
    throw asking.signal.aborted ? new Refused(OVERTAKEN, '') : new Refused(0, OVER);
  }
  if (!answer.ok) throw new Refused(answer.status, new TextDecoder().decode(buffer).trim());
  const length = new DataView(buffer).getUint32(0, true);
  const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { meta, bytes: new Uint8ClampedArray(buffer, 4 + length) };
}

const OVERTAKEN = 409;
const CLOSED = 410;
const OVER = 'The program has ended, or cannot be reached.';

function complain(error) {
  if (error.status === OVERTAKEN) return;
  say(error.message);
}

// The question whose answer comes when the program ends.
const ending = new AbortController();

// Says when the program has ended, and when it can be reached again.
async function listen() {
  let failures = 0;
  while (!ending.signal.aborted) {
    try {
      const answer = await fetch('/alive', { method: 'POST', headers: { 'X-Key': key }, body: '', signal: ending.signal });
      await answer.text();
      if (answer.status === 403) return showOver('The program has ended.');
      failures = 0;
      if (document.body.classList.contains('ended')) showOver('');
    } catch {
      if (ending.signal.aborted) return;
      // A connection may break; the program has ended where a second one fails, too.
      if (++failures === 2) showOver(OVER);
      await new Promise((done) => { setTimeout(done, failures < 2 ? 200 : 3000); });
    }
  }
}

// What needs the program.
const ASKING = ['save', 'quit', 'frame', 'zooming', 'home', 'keep', 'controls', 'tracing', 'largest', 'looks', 'file'];

// Shows that the program is over; an empty text shows that it is not.
function showOver(text) {
  document.body.classList.toggle('ended', text !== '');
  for (const id of ASKING) find(id).inert = text !== '';
  find('over').hidden = text === '';
  find('over').textContent = text && `${text} This page keeps what it has shown last.`;
}

// A time in the unit in which it is short.
function duration(milliseconds) {
  if (milliseconds < 1000) return `${milliseconds.toFixed(milliseconds < 10 ? 1 : 0)} ms`;
  const seconds = milliseconds / 1000;
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

// A number with a gap after each three digits.
const grouped = (number) => Math.round(number).toLocaleString('en').replaceAll(',', '\u202f');

// A text with its long numbers grouped.
const groupedIn = (text) => text.replace(/(?<![\d.])\d{5,}(?![\d.])/g, (digits) => grouped(Number(digits)));

let silence = 0;

// Shows a message for a while.
function say(text) {
  const message = find('message');
  message.textContent = text;
  message.hidden = text === '';
  clearTimeout(silence);
  silence = setTimeout(() => { message.hidden = true; }, 6000);
}
