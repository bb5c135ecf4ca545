// SPDX-License-Identifier: Apache-2.0
// Starts the worker that decodes the model, from files beside the page or from what stands inside it (a page of one file).

function inside(id) {
  const element = document.getElementById(id);
  return element && element.textContent.trim() !== "" ? element.textContent : null;
}

function source(id, name) {
  const base64 = inside(id);
  return base64 ? { base64: base64.trim() } : { url: new URL(name, document.baseURI).href };
}

/** `on`: what is called with each message of the worker, by its type. */
export function loadModel(on) {
  const code = inside("sheen-worker");
  const url = code ? URL.createObjectURL(new Blob([code], { type: "text/javascript" })) : "worker.js";
  const worker = new Worker(url);
  worker.onmessage = ({ data }) => on[data.type](data);
  worker.onerror = () => on.failed({ message: "The decoder could not be started." });
  worker.postMessage({ type: "open", program: source("sheen-wasm", "sheen.wasm"),
                       model: source("sheen-model", document.body.dataset.model) });
  return { ask: (message) => worker.postMessage(message) };
}
