// SPDX-License-Identifier: Apache-2.0
// What the workers of all kinds of models have in common: the WebAssembly module, the file that arrives, tables of numbers.

const decoder = { calls: null, tables: {}, cpuMs: 0 };

/** A copy of a table of the decoder's, as numbers of the type. */
export function table(name, Numbers) {
  const { memory } = decoder.calls, at = decoder.calls.sheen_table(decoder.tables[name]);
  const [data, bytes] = new Uint32Array(memory.buffer, at, 2);
  return new Numbers(memory.buffer.slice(data, data + bytes));
}

/** What a call of the decoder gave, unless that is an error. */
export function checked(result) {
  if (result < 0) throw new Error(new TextDecoder().decode(table("error", Uint8Array)));
  return result;
}

export function send(message) {
  const buffers = Object.values(message).filter(ArrayBuffer.isView).map((numbers) => numbers.buffer);
  postMessage(message, buffers);
}

export function timed(work) {
  const begun = performance.now();
  try {
    return work();
  } finally {
    decoder.cpuMs += performance.now() - begun;
  }
}

function addBytes(bytes) {
  const at = decoder.calls.sheen_more(bytes.length);
  new Uint8Array(decoder.calls.memory.buffer, at, bytes.length).set(bytes);
}

/** `decode(last)`: decodes what has arrived. */
async function open({ program, model }, decode) {
  const imports = {
    env: { emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: { proc_exit(status) { throw new Error(`The decoder ended by itself (${status}).`); } },
  };
  const instantiated = await WebAssembly.instantiate(await bytesOf(program), imports);
  decoder.calls = instantiated.instance.exports;
  decoder.calls._initialize();
  if (model.base64) {
    addBytes(await bytesOf(model));
  } else {
    const answer = await fetch(model.url);
    if (!answer.ok) throw new Error(`The model ${model.url} is not there (${answer.status}).`);
    const reader = answer.body.getReader();
    for (let arrived = 0;;) {
      const { done, value } = await reader.read();
      if (done) break;
      addBytes(value);
      arrived += value.length;
      send({ type: "arrived", bytes: arrived });
      decode(false);
    }
  }
  decode(true);
}

/** Of a URL, or of text in base64. */
async function bytesOf({ url, base64 }) {
  if (base64) return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url} is not there (${answer.status}).`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** A worker: `tables`: their numbers by name; `decode(calls, last)`: what becomes of bytes that have arrived; `on`: what is
 * called with each message of the page, by its type. */
export function serve(tables, decode, on) {
  decoder.tables = tables;
  onmessage = async ({ data }) => {
    try {
      if (data.type === "open") await open(data, (last) => decode(decoder.calls, last));
      else on[data.type](decoder.calls, data);
    } catch (error) {
      send({ type: "failed", message: error.message });
    }
  };
}

/** What loading took so far. */
export const cost = () => ({ cpuMs: decoder.cpuMs, heapBytes: decoder.calls.memory.buffer.byteLength });
