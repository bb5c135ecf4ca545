// SPDX-License-Identifier: Apache-2.0
// Points on the object that somebody has written something about: a numbered button at each, and a card with its text.
import { cross, dot, subtract } from "./vectors.js";

const NEARLY = 0.995; // of the way to a point: what is nearer hides it

/** Whether the surface stands between the eye and the point. */
function hidden(eye, point, vertices, triangles) {
  const ray = subtract(point, eye);
  const at = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
  for (let t = 0; t < triangles.length; t += 3) {
    const a = at(triangles[t]), ab = subtract(at(triangles[t + 1]), a), ac = subtract(at(triangles[t + 2]), a);
    const p = cross(ray, ac), determinant = dot(ab, p);
    if (Math.abs(determinant) < 1e-20) continue;
    const from = subtract(eye, a), u = dot(from, p) / determinant;
    if (u < 0 || u > 1) continue;
    const q = cross(from, ab), v = dot(ray, q) / determinant;
    if (v < 0 || u + v > 1) continue;
    const way = dot(ac, q) / determinant;
    if (way > 0 && way < NEARLY) return true;
  }
  return false;
}

export class Notes {
  /** `notes`: { at, title, text }, in the frame of the file, whose zero is `origin` before that of the mesh. */
  constructor(notes, origin, choose) {
    this.layer = document.getElementById("notes");
    this.card = document.getElementById("card");
    this.notes = notes.map((note, i) => {
      const button = document.createElement("button");
      button.textContent = String(i + 1);
      button.setAttribute("aria-label", `Note ${i + 1}: ${note.title}`);
      button.title = note.title;
      button.onclick = () => this.open(i, choose);
      this.layer.append(button);
      return { ...note, at: subtract(note.at, origin), button };
    });
    document.getElementById("close-card").onclick = () => this.close();
    this.card.onkeydown = (event) => event.key === "Escape" && this.close();
  }

  open(i, choose) {
    const note = this.notes[i];
    this.opened = i;
    this.card.hidden = false;
    this.card.querySelector("h2").textContent = note.title;
    this.card.querySelector("p").textContent = note.text ?? "";
    this.notes.forEach(({ button }, k) => button.setAttribute("aria-expanded", String(k === i)));
    choose(note);
    document.getElementById("close-card").focus({ preventScroll: true });
  }

  close() {
    this.card.hidden = true;
    this.notes.forEach(({ button }) => button.setAttribute("aria-expanded", "false"));
    this.notes[this.opened]?.button.focus({ preventScroll: true });
  }

  /** Each button to where its point is seen, in a picture of this size on the page. */
  place(orbit, width, height) {
    for (const { at, button } of this.notes) {
      const [x, y] = orbit.project(at, width, height);
      button.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
    }
  }

  /** Those behind the object are faint. */
  settle(orbit, vertices, triangles) {
    for (const { at, button } of this.notes)
      button.classList.toggle("behind", hidden(orbit.eye(), at, vertices, triangles));
  }
}
