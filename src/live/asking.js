'use strict';
// Questions to the program. Every answer is a description in JSON and the bytes that it describes.

const key = new URLSearchParams(location.search).get('key') || '';
// Of the pictures that one page asks for, a later turn overtakes the earlier ones.
const page = Math.floor(Math.random() * 2 ** 50);
let turn = 0;

const find = (id) => document.getElementById(id);

class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

// Asks, and returns { meta, bytes }. A refusal is thrown, with its status and its reason.
async function ask(path, question) {
  const body = question instanceof Blob ? question : JSON.stringify(question || {});
  let answer;
  try {
    answer = await fetch(path, { method: 'POST', headers: { 'X-Key': key }, body, cache: 'no-store' });
  } catch {
    throw new Refused(0, 'The program has ended, or cannot be reached.');
  }
  if (!answer.ok) throw new Refused(answer.status, (await answer.text()).trim());
  const buffer = await answer.arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (meta.overtaken) throw new Refused(OVERTAKEN, '');
  return { meta, bytes: new Uint8ClampedArray(buffer, 4 + length) };
}

const OVERTAKEN = 409;
const CLOSED = 410;

function complain(error) {
  if (error.status === OVERTAKEN) return;
  say(error.message);
}

let silence = 0;

// Shows a message for a while.
function say(text) {
  const message = find('message');
  message.textContent = text;
  message.hidden = text === '';
  clearTimeout(silence);
  silence = setTimeout(() => { message.hidden = true; }, 6000);
}
