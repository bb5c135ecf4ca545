// SPDX-License-Identifier: Apache-2.0
// Decodes an irradiance field, away from the page's own thread, and paints its picture in each light.
import { checked, cost, send, serve, table, timed } from "./decoder.js";

function decode(decoder, last) {
  if (timed(() => checked(decoder.sheen_read(last ? 1 : 0))) === 0) return;
  send({ type: "scene", scene: table("scene", Float64Array), lights: table("lights", Float64Array), ...cost() });
}

function light(decoder, { place }) {
  checked(decoder.sheen_light(...place));
  send({ type: "lit", place, pixels: table("pixels", Uint8ClampedArray) });
}

serve({ error: 0, scene: 1, lights: 2, pixels: 3 }, decode, { light });
