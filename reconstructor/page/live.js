// SPDX-License-Identifier: Apache-2.0
// Asks the reconstructor again and again what has changed in its model (LightFieldStream), and what another eye sees.
import { LiveMaps, readScene } from "./live_maps.js";

const POLL_MS = 250, BUSY_MS = 100, AWAY_MS = 1000, PATIENCE_MS = 10000;

const soon = (ms, woken) => new Promise((go) => {
  const timer = setTimeout(go, ms);
  woken(() => (clearTimeout(timer), go()));
});

/** `on`: what is called with each message, by its type, as by `loadModel`. */
export function watchModel(on) {
  const token = new URLSearchParams(location.search).get("token");
  const headers = token ? { Authorization: `Bearer ${token}` } : {};
  const desk = { maps: null, changes: 0, more: false, eye: [0, 0, 0], from: null, seen: null, wake() {} };

  const get = (path) => fetch(path, { headers, cache: "no-store", signal: AbortSignal.timeout(PATIENCE_MS) });

  /** Returns how long to wait before the next question. */
  function whenRefused({ status }) {
    if (status === 503) return BUSY_MS;
    const why = { 401: "The token is wrong or missing.", 404: "The object appears with the capture.", 429: "Too many wrong tokens." };
    on.waits({ message: why[status] ?? `The reconstructor answers with an error (${status}).` });
    return AWAY_MS;
  }

  async function askForScene() {
    const answer = await get("scene");
    if (!answer.ok) return whenRefused(answer);
    const scene = readScene(await answer.arrayBuffer());
    desk.maps = new LiveMaps(scene);
    desk.changes = 0;
    desk.more = false;
    on.mesh({ ...scene, cameras: new Float32Array(0), grows: true });
    return 0;
  }

  /** What has changed comes first, in pieces as one eye sees them; then what else another eye sees, when its turn has come. */
  async function askForChanges() {
    const { maps, changes } = desk;
    if (!desk.more) desk.from = desk.eye;
    const { from } = desk, moved = !desk.more && from !== desk.seen;
    const answer = await get(`changes?scene=${maps.scene}&changes=${changes}&eye=${from.join()}${moved ? "&moved=1" : ""}`);
    if (!answer.ok) return whenRefused(answer);
    const bytes = await answer.arrayBuffer(), told = maps.told(bytes);
    if (told.scene !== maps.scene) {
      desk.maps = null;
      return 0;
    }
    desk.changes = told.changes;
    desk.more = told.more;
    if (told.seen) desk.seen = from;
    if (!told.empty)
      on.grown({ put: (viewer) => maps.put(bytes, viewer), seen: told.seen, whole: !told.more, waitedMs: told.waitedMs });
    const waits = moved && !told.seen;
    return told.more || (!waits && desk.eye !== desk.seen) ? 0 : POLL_MS;
  }

  (async () => {
    for (;;) {
      if (document.hidden) await new Promise((go) => document.addEventListener("visibilitychange", go, { once: true }));
      let rest = AWAY_MS;
      try {
        rest = await (desk.maps ? askForChanges() : askForScene());
      } catch (error) {
        on.waits({ message: "The reconstructor does not answer: this is how the object looked." });
      }
      if (rest > 0) await soon(rest, (wake) => (desk.wake = wake));
    }
  })();

  return {
    ask({ eye }) {
      desk.eye = eye;
      desk.wake();
    },
  };
}
