// SPDX-License-Identifier: Apache-2.0
// Decodes a surface light field as it arrives, away from the page's own thread, and krigs the coefficients of each eye.
import { checked, cost, send, serve, table, timed } from "./decoder.js";

const TABLES = { error: 0, scene: 1, cameras: 2, vertices: 3, triangles: 4, edges: 5, places: 6, means: 7, terms: 8,
                 coefficients: 9 };
const STAGES = { nothing: 0, mesh: 1, means: 2, terms: 3 };

let whole = false;

/** Decodes and sends what has arrived. */
function decode(decoder, last) {
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
           ...cost() });
    return;
  }
}

function look(decoder, { eye }) {
  if (!whole) return;
  checked(decoder.sheen_look(...eye));
  send({ type: "seen", coefficients: table("coefficients", Float32Array), exposure: decoder.sheen_exposure(...eye) });
}

serve(TABLES, decode, { look });
