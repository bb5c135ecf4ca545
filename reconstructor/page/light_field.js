// SPDX-License-Identifier: Apache-2.0
// A surface light field in the room: what is loaded, what is looked at, what is said.
import { CameraPyramids, cameraReach } from "./cameras.js";
import { Notes } from "./notes.js";
import { Orbit } from "./orbit.js";
import { Painter } from "./painter.js";
import { about, canvas, element, fail, furnish, linkTo, linkedPoint, say, setState } from "./room.js";
import { nearestPhotographDeg, viewName } from "./view_words.js";
import { add, clamp, scaled, subtract, unit } from "./vectors.js";
import { Viewer } from "./viewer.js";

const FAR_FROM_PHOTOGRAPHS_DEG = 15;
const CAMERAS_SEEN_FROM = 2.4; // of the distance of the furthest camera: there most are in the picture
const STEEPEST_NOTE = 0.9; // rad: notes on top of the object are seen obliquely
const FLIGHT_MS = 700; // from a view to another
const MOST_TEXELS_KEPT = 16e6; // against the loss of the graphics; of larger models all is decoded again

const page = { viewer: null, painter: null, orbit: null, cameras: null, worker: null, whole: false, markGuesses: true, showCameras: false,
               origin: [0, 0, 0], pending: false, figures: {}, kept: { room: 0, terms: [] } };

/** The coefficients of the eye, where they are not those that are there. One question at a time. */
function askForEye() {
  if (!page.whole || page.pending) return;
  const eye = page.orbit.eye(), asked = eye.join();
  if (asked === page.askedEye) return;
  page.pending = true;
  page.askedEye = asked;
  page.worker.ask({ type: "look", eye });
}

function changed() {
  if (!page.orbit || !page.painter) return;
  askForEye();
  page.painter.change();
  page.notes.place(page.orbit, canvas.clientWidth, canvas.clientHeight);
  clearTimeout(page.settling);
  page.settling = setTimeout(settled, 250);
}

/** The hand has let go: what is seen is named, and the address of the page is that of the view. */
function settled() {
  const { orbit, cameras, origin } = page;
  say("view-name", viewName(orbit));
  const away = nearestPhotographDeg(cameras, orbit);
  const notes = [];
  if (page.figures.missingLayers > 0) notes.push("the file is cut short: the picture is coarser than it was");
  if (away > FAR_FROM_PHOTOGRAPHS_DEG) notes.push(`no photograph from here: the nearest is ${Math.round(away)} degrees away`);
  say("note", notes.join("; "));
  page.notes.settle(orbit, page.kept.mesh.vertices, page.kept.mesh.triangles);
  const inFrame = (point) => add(point, origin);
  if (page.turned) linkTo({ eye: inFrame(orbit.eye()), target: inFrame(orbit.target) });
}

function resized(width, height) {
  if (page.orbit && !page.turned && !page.linked && !about.eye) page.orbit.home(width, height);
  changed();
}

/** eye=x,y,z and target=x,y,z behind # in the address. */
function followLink() {
  if (!page.orbit) return false;
  const eye = linkedPoint("eye"), target = linkedPoint("target");
  if (!eye) return false;
  page.orbit.place(subtract(eye, page.origin), target ? subtract(target, page.origin) : page.orbit.centre);
  return true;
}

/** The first view: as who made the page says, else all of the object from where most photographs were taken. */
function goHome() {
  const { orbit, origin } = page, before = orbit.view();
  orbit.home(canvas.width, canvas.height);
  if (about.eye) orbit.place(subtract(about.eye, origin), about.target ? subtract(about.target, origin) : orbit.centre);
  const home = orbit.view();
  page.turned = page.linked = false;
  linkTo({});
  if (page.opened) fly(before, home);
  page.opened = true;
}

/** From view to view, at once for who does not want motion. */
function fly(from, to) {
  cancelAnimationFrame(page.flight);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches, begun = performance.now();
  const step = (now) => {
    const part = still ? 1 : Math.min(1, Math.max(0, now - begun) / FLIGHT_MS);
    page.orbit.between(from, to, part * part * (3 - 2 * part));
    changed();
    if (part < 1) page.flight = requestAnimationFrame(step);
  };
  step(begun);
}

/** Turns the noted point to the eye. */
function lookAtNote({ at }) {
  const { orbit } = page, before = orbit.view();
  orbit.lookFrom(add(unit(subtract(at, orbit.centre)), scaled(orbit.direction(), 0.35)));
  orbit.elevation = clamp(orbit.elevation, -STEEPEST_NOTE, STEEPEST_NOTE);
  page.turned = true;
  fly(before, orbit.view());
}

const hands = {
  orbit: (right, up) => turn((orbit) => orbit.orbit(right, up)),
  drag: (right, down) => hands.orbit(-right, down),
  pan: (right, up) => turn((orbit) => orbit.pan(right, up)),
  zoom: (factor) => turn((orbit) => orbit.zoom(factor)),
};

function turn(how) {
  if (!page.orbit) return;
  cancelAnimationFrame(page.flight);
  how(page.orbit);
  page.turned = true;
  changed();
}

function toggleGuesses() {
  page.markGuesses = !page.markGuesses;
  element("guesses").setAttribute("aria-pressed", String(page.markGuesses));
  changed();
}

function toggleCameras() {
  if (!page.orbit) return;
  page.showCameras = !page.showCameras;
  element("cameras").setAttribute("aria-pressed", String(page.showCameras));
  const { orbit } = page, before = orbit.view();
  orbit.reach = page.showCameras ? cameraReach(page.cameras, orbit.centre) : 0;
  if (page.showCameras) page.nearDistance = before.distance;
  const distance = page.showCameras ? Math.max(before.distance, CAMERAS_SEEN_FROM * orbit.reach) : page.nearDistance;
  fly(before, { ...before, distance });
}

/** The object is there. */
function enter(scene, vertices) {
  page.orbit = new Orbit(scene, vertices);
  if (about.up) page.orbit.setUp(about.up);
  page.notes = new Notes(about.notes ?? [], page.origin, lookAtNote);
  const link = location.hash;
  goHome();
  if (link) location.hash = link;
  page.linked = followLink();
}

const onMessage = {
  arrived({ bytes }) {
    page.figures.bytes = bytes;
  },
  mesh({ scene, cameras, vertices, triangles, edges, grows }) {
    page.kept.mesh = { vertices, triangles, edges, brightest: scene[13] };
    page.origin = Array.from(scene.slice(10, 13));
    page.cameras = cameras;
    page.viewer.setMesh(page.kept.mesh);
    page.whole = page.grows = grows === true;
    page.pending = false;
    page.askedEye = null;
    page.pyramids = new CameraPyramids(page.viewer.gl, cameras, scene[3]);
    if (page.orbit) page.orbit.vertices = vertices; // another mesh of the same object: whoever looks stays there
    else enter(scene, vertices);
    setState("mesh");
    changed();
  },
  means({ places, means }) {
    page.figures.bytesToColours ??= page.figures.bytes;
    page.kept.means = { places, means };
    page.viewer.setMeans(places, means);
    if (document.body.dataset.state === "mesh") setState("means");
    changed();
  },
  room({ texels }) {
    page.kept.room = texels;
    page.viewer.setBasisRoom(texels);
  },
  terms({ texels }) {
    if (page.kept.room <= MOST_TEXELS_KEPT) page.kept.terms.push(texels);
    page.viewer.addBasis(texels);
  },
  whole({ maxTerms, missingLayers, cpuMs, heapBytes }) {
    Object.assign(page.figures, { missingLayers, cpuMs, heapBytes, texels: page.viewer.basisRows * 4096 });
    page.whole = true;
    page.maxTerms = maxTerms;
    askForEye();
  },
  seen({ coefficients, exposure }) {
    page.pending = false;
    if (page.viewer.gl.isContextLost()) return;
    page.viewer.setCoefficients(coefficients, page.maxTerms, exposure);
    setState("whole");
    changed();
  },
  /** Of a model that is being captured: `put` brings it to the graphics. */
  grown({ put, seen, whole, waitedMs }) {
    if (seen) page.pending = false;
    if (page.viewer.gl.isContextLost()) return;
    const cameras = put(page.viewer);
    if (cameras) page.cameras = cameras;
    if (cameras) page.pyramids = new CameraPyramids(page.viewer.gl, cameras, page.orbit.radius);
    if (whole) page.figures.changes = (page.figures.changes ?? 0) + 1;
    page.figures.waitedMs = waitedMs;
    if (whole) setState("whole");
    changed();
  },
  waits: ({ message }) => say("note", message),
  failed: ({ message }) => fail(message),
};

function startDrawing() {
  const gl = canvas.getContext("webgl2", { alpha: true, antialias: false, powerPreference: "high-performance" });
  if (!gl) throw new Error("This browser has no WebGL 2, which this page draws with.");
  page.viewer = new Viewer(gl);
  page.painter = new Painter(gl, canvas, (width, height, how) => {
    if (!page.orbit) return;
    if (how.outlines) return page.viewer.drawOutlines(page.orbit, width, height);
    page.viewer.draw(page.orbit, width, height, { ...how, markGuesses: page.markGuesses });
    if (page.showCameras) page.pyramids.draw(page.orbit, width, height);
  });
}

/** `load`: gives the messages of `onMessage`, and asks for what an eye sees. */
export function startLightField(load) {
  startDrawing();
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", restore);
  furnish({
    label: "The object. Arrow keys turn it, plus and minus zoom, R goes back to the first view.",
    hands, resized, home: () => page.orbit && goHome(), followLink: () => followLink() && changed(),
    switches: [{ id: "guesses", key: "g", turn: toggleGuesses }, { id: "cameras", key: "c", turn: toggleCameras }],
  });
  page.worker = load(onMessage);
  window.sheen = interfaceOfPage;
}

/** The graphics have lost all that they had (another program took them, a phone slept): from what was kept, or anew. */
function restore() {
  const { mesh, means, room, terms } = page.kept;
  if (room > MOST_TEXELS_KEPT || page.grows) return location.reload(); // the address names the view
  startDrawing();
  if (mesh) page.viewer.setMesh(mesh);
  if (mesh) page.pyramids = new CameraPyramids(page.viewer.gl, page.cameras, page.orbit.radius);
  if (means) page.viewer.setMeans(means.places, means.means);
  page.viewer.setBasisRoom(room);
  for (const texels of terms) page.viewer.addBasis(texels);
  page.askedEye = null;
  changed();
}

/** For pages that embed this one, and for tests. */
const interfaceOfPage = {
  /** Where the object stands: the middle of its box, half its diagonal, and where zero is in its file. */
  get scene() {
    return { centre: page.orbit.centre, radius: page.orbit.radius, origin: page.origin };
  },
  /** What loading took. */
  figures: () => ({ state: document.body.dataset.state, frames: page.painter?.frames, fineMs: page.painter?.pacer.fineMs,
                    pixel: page.painter?.pacer.frame().pixel, // of a moving picture, in those of the canvas
                    ...page.figures }),
  /** Looks from there; resolves when the picture is as fine as can be: RGBA, bottom row first. */
  async lookFrom(eye, target, up, { markGuesses = true } = {}) {
    const moved = (point) => point.map((x, i) => x - page.origin[i]);
    if (up) page.orbit.setUp(up);
    page.orbit.place(moved(eye), moved(target));
    page.markGuesses = markGuesses;
    page.turned = true;
    changed();
    do await page.painter.finished();
    while (page.pending || page.askedEye !== page.orbit.eye().join());
    return page.painter.read();
  },
};
