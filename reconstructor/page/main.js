// SPDX-License-Identifier: Apache-2.0
// The page: what it shows by the kind of its model.
import { startLightField } from "./light_field.js";
import { loadModel } from "./loader.js";
import { startRelitPicture } from "./relit_picture.js";
import { fail } from "./room.js";

const KINDS = { slf: () => startLightField(loadModel), rif: startRelitPicture };

try {
  KINDS[document.body.dataset.model.split(".").pop()]();
} catch (error) {
  fail(error.message);
}
