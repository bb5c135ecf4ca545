// SPDX-License-Identifier: Apache-2.0
// The room that a model stands in, whatever its kind: canvas, title and text, buttons, what is said, the page's address.
import { Controls } from "./controls.js";

const MOST_PIXELS = 1920 * 1200; // a phone's screen has more than its graphics shade

export const element = (id) => document.getElementById(id);
export const canvas = element("view");
export const about = JSON.parse(element("about").textContent);

export function say(id, text) {
  if (element(id).textContent !== text) element(id).textContent = text;
  element(id).hidden = text === "";
}

export function setState(state) {
  document.body.dataset.state = state;
}

export function fail(message) {
  setState("failed");
  say("failure", message);
}

/** Three numbers behind # in the address, as in name=x,y,z; null where they are not there. */
export function linkedPoint(name) {
  const numbers = (new URLSearchParams(location.hash.slice(1)).get(name) ?? "").split(",").map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
}

/** The address of the page becomes that of these points; of none, that of the page itself. */
export function linkTo(points) {
  const digits = (point) => point.map((x) => Number(x.toPrecision(7))).join(",");
  const link = Object.entries(points).map(([name, point]) => `${name}=${digits(point)}`).join("&");
  history.replaceState(null, "", link ? `#${link}` : location.pathname + location.search);
}

/** The canvas has as many pixels as the screen, up to a limit; `resized`: called when they are others. */
function fitCanvas(resized) {
  const css = canvas.clientWidth * canvas.clientHeight;
  const scale = Math.min(window.devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / Math.max(1, css)));
  const width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
  if (canvas.width === width && canvas.height === height) return;
  canvas.width = width;
  canvas.height = height;
  resized(width, height);
}

function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.();
}

/** `kind`: { label, hands (as of Controls, but for keys), home(), resized(width, height), followLink(), switches }, where a
 * switch is { id, key, turn() }: a button of the page that stands for something else in other kinds of models. */
export function furnish(kind) {
  const keys = { r: kind.home, home: kind.home, f: toggleFullScreen };
  for (const { id, key, turn } of kind.switches) {
    element(id).hidden = false;
    element(id).onclick = turn;
    keys[key] = turn;
  }
  const key = (name) => {
    keys[name]?.();
    return keys[name] !== undefined;
  };
  new Controls(canvas, { ...kind.hands, key });
  canvas.setAttribute("aria-label", kind.label);
  new ResizeObserver(() => fitCanvas(kind.resized)).observe(canvas);
  fitCanvas(kind.resized);
  element("home").onclick = kind.home;
  element("nearer").onclick = () => kind.hands.zoom(1 / 1.25);
  element("farther").onclick = () => kind.hands.zoom(1.25);
  element("full-screen").onclick = toggleFullScreen;
  element("full-screen").hidden = !document.fullscreenEnabled;
  say("text", about.text ?? "");
  window.addEventListener("hashchange", kind.followLink);
}
