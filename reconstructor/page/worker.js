// SPDX-License-Identifier: Apache-2.0
// Decodes the model as it arrives, away from the page's own thread, and krigs the coefficients of each eye.
"use strict";

const TABLES = { error: 0, scene: 1, cameras: 2, vertices: 3, triangles: 4, edges: 5, places: 6, means: 7, terms: 8,
                 coefficients: 9 };
const STAGES = { nothing: 0, mesh: 1, means: 2, terms: 3 };

let decoder = null; // what the WebAssembly module exports
let whole = false;
let cpuMs = 0;

/** A copy of a table of the decoder's, as numbers of the type. */
function table(name, Numbers) {
  const at = decoder.sheen_table(TABLES[name]);
  const [data, bytes] = new Uint32Array(decoder.memory.buffer, at, 2);
  return new Numbers(decoder.memory.buffer.slice(data, data + bytes));
}

function checked(result) {
  if (result < 0) throw new Error(new TextDecoder().decode(table("error", Uint8Array)));
  return result;
}

function send(message) {
  const buffers = Object.values(message).filter(ArrayBuffer.isView).map((numbers) => numbers.buffer);
  postMessage(message, buffers);
}

function timed(work) {
  const begun = performance.now();
  try {
    return work();
  } finally {
    cpuMs += performance.now() - begun;
  }
}

function add(bytes) {
  const at = decoder.sheen_more(bytes.length);
  new Uint8Array(decoder.memory.buffer, at, bytes.length).set(bytes);
}

/** Decodes and sends what has arrived. */
function decode(last) {
  for (;;) {
    const stage = timed(() => checked(decoder.sheen_read(last ? 1 : 0)));
    if (stage === STAGES.nothing) return;
    if (stage === STAGES.mesh)
      send({ type: "mesh", scene: table("scene", Float64Array), cameras: table("cameras", Float32Array),
             vertices: table("vertices", Float32Array), triangles: table("triangles", Uint32Array),
             edges: table("edges", Uint32Array) });
    else
      send({ type: "means", places: table("places", Uint32Array), means: table("means", Uint8Array) });
    if (stage !== STAGES.terms) continue;
    send({ type: "room", texels: decoder.sheen_term_texels() });
    while (timed(() => checked(decoder.sheen_next_terms())) > 0) send({ type: "terms", texels: table("terms", Uint8Array) });
    whole = true;
    send({ type: "whole", maxTerms: decoder.sheen_max_terms(), missingLayers: decoder.sheen_missing_layers(),
           cpuMs, heapBytes: decoder.memory.buffer.byteLength });
    return;
  }
}

async function open({ program, model }) {
  const imports = {
    env: { emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: { proc_exit(status) { throw new Error(`The decoder ended by itself (${status}).`); } },
  };
  const instantiated = await WebAssembly.instantiate(await bytesOf(program), imports);
  decoder = instantiated.instance.exports;
  decoder._initialize();
  if (model.base64) {
    add(await bytesOf(model));
  } else {
    const answer = await fetch(model.url);
    if (!answer.ok) throw new Error(`The model ${model.url} is not there (${answer.status}).`);
    const reader = answer.body.getReader();
    for (let arrived = 0;;) {
      const { done, value } = await reader.read();
      if (done) break;
      add(value);
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

function look({ eye, id }) {
  if (!whole) return;
  checked(decoder.sheen_look(...eye));
  send({ type: "seen", id, coefficients: table("coefficients", Float32Array), exposure: decoder.sheen_exposure(...eye) });
}

onmessage = async ({ data }) => {
  try {
    if (data.type === "open") await open(data);
    if (data.type === "look") look(data);
  } catch (error) {
    send({ type: "failed", message: error.message });
  }
};
