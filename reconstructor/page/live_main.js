// SPDX-License-Identifier: Apache-2.0
// The page of a running capture.
import { startLightField } from "./light_field.js";
import { watchModel } from "./live.js";
import { fail } from "./room.js";

document.body.classList.toggle("framed", window.parent !== window);
try {
  startLightField(watchModel);
} catch (error) {
  fail(error.message);
}
