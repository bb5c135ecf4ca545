// SPDX-License-Identifier: Apache-2.0
// An irradiance field in the room: the view is that of its camera, the hand moves the light. Two fingers, the wheel and
// buttons bring the picture nearer.
import { LightBall, lightName, turned } from "./light_ball.js";
import { loadModel } from "./loader.js";
import { about, canvas, element, fail, furnish, linkTo, linkedPoint, say, setState } from "./room.js";
import { clamp, dot, scaled, add, unit } from "./vectors.js";

const FAR_FROM_LIGHTS_DEG = 15;
const FIRST_LIGHT = [-0.5, 0.6, 0.62]; // as in drawings, from the upper left
const MARGIN = 12; // pixels of the page between the picture and what stands above and below it
const NEAREST = 16; // times as large

class RelitPicture {
  constructor() {
    this.view = { scale: 1, right: 0, up: 0 }; // centre of what is seen, in shorter sides of the canvas
    this.direction = null; // towards the light: right, up, towards the eye
    this.pending = false;
    this.figures = {};
    this.waiting = []; // for a picture in the newest light
    this.picture = document.createElement("canvas");
    this.ball = new LightBall(element("light-ball"), (direction) => this.moveLight(direction));
  }

  start() {
    furnish({
      label: "The picture. Arrow keys move the light, plus and minus zoom, R goes back to the first light.",
      hands: {
        orbit: (right, up) => this.scene && this.moveLight(turned(this.direction, right, up)),
        drag: (right, down) => this.scene && this.moveLight(turned(this.direction, right / 2, -down / 2)),
        pan: (right, up) => this.move((view) => Object.assign(view, { right: view.right + right, up: view.up + up })),
        zoom: (factor) => this.zoom(factor),
      },
      switches: [],
      home: () => this.scene && this.goHome(),
      resized: () => this.draw(),
      followLink: () => this.scene && this.followLink(),
    });
    this.worker = loadModel({
      arrived: ({ bytes }) => Object.assign(this.figures, { bytes }),
      scene: (message) => this.open(message),
      lit: (message) => this.lit(message),
      failed: ({ message }) => fail(message),
    });
  }

  open({ scene, lights, cpuMs, heapBytes }) {
    const [width, height, near, away] = scene, axis = (i) => Array.from(scene.slice(4 + 3 * i, 7 + 3 * i));
    this.scene = { width, height, near: near === 1, away, axes: [axis(0), scaled(axis(1), -1), scaled(axis(2), -1)] };
    this.lights = Array.from({ length: lights.length / 3 }, (_, i) => this.directionOf(lights.slice(3 * i, 3 * i + 3)));
    Object.assign(this.figures, { cpuMs, heapBytes });
    [this.picture.width, this.picture.height] = [width, height];
    element("light-ball").hidden = false;
    const link = linkedPoint("light");
    this.goHome();
    if (link) this.lightAt(link);
  }

  /** Of a place in the object's frame: right, up, towards the eye. */
  directionOf(place) {
    return unit(this.scene.axes.map((axis) => dot(axis, place)));
  }

  placeOf(direction) {
    const { axes, near, away } = this.scene;
    const towards = axes.map((axis, i) => scaled(axis, direction[i])).reduce(add);
    return scaled(towards, near ? away : 1);
  }

  moveLight(direction) {
    this.turned = true;
    this.lightAt(this.placeOf(direction));
  }

  /** A place, or a direction, as in lists of lights. */
  lightAt(place) {
    this.place = Array.from(place);
    this.direction = this.directionOf(place);
    this.ball.show(this.direction, this.lights);
    this.ask();
    clearTimeout(this.settling);
    this.settling = setTimeout(() => this.settled(), 250);
  }

  /** One picture at a time: that of the newest light. */
  ask() {
    if (this.pending) return;
    this.pending = true;
    this.asked = this.place;
    this.worker.ask({ type: "light", place: this.place });
  }

  lit({ pixels }) {
    const { width, height } = this.scene;
    this.pending = false;
    this.pixels = pixels;
    this.picture.getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
    setState("whole");
    this.draw();
    if (this.asked !== this.place) return this.ask();
    for (const resolve of this.waiting.splice(0)) resolve({ width, height, pixels });
  }

  settled() {
    say("view-name", lightName(this.direction));
    const away = this.ball.nearestDeg();
    say("note", away > FAR_FROM_LIGHTS_DEG ? `no image in light from here: the nearest is ${Math.round(away)} degrees away` : "");
    if (this.turned) linkTo({ light: this.place });
  }

  /** The first light, and all of the picture. */
  goHome() {
    const likeFirst = (light) => dot(light, FIRST_LIGHT);
    const nearest = this.lights.reduce((best, light) => (likeFirst(light) > likeFirst(best) ? light : best));
    this.turned = false;
    linkTo({});
    this.move((view) => Object.assign(view, { scale: 1, right: 0, up: 0 }));
    this.lightAt(about.light ?? this.placeOf(nearest));
  }

  followLink() {
    const link = linkedPoint("light");
    if (link) this.lightAt(link);
  }

  zoom(factor) {
    this.move((view) => {
      const before = view.scale;
      view.scale = clamp(before / factor, 1, NEAREST);
      view.right *= view.scale / before;
      view.up *= view.scale / before;
    });
  }

  move(how) {
    const most = (this.view.scale - 1) / 2 + 0.5 * (this.view.scale > 1);
    how(this.view);
    this.view.right = clamp(this.view.right, -most, most);
    this.view.up = clamp(this.view.up, -most, most);
    this.draw();
  }

  /** Where the whole picture stands, between title and buttons: first row and height, in pixels of the canvas. */
  stage() {
    const perPixel = canvas.height / Math.max(1, canvas.clientHeight), box = (id) => element(id).getBoundingClientRect();
    const under = document.querySelector("header").getBoundingClientRect().bottom + MARGIN, ball = box("light-ball");
    const beside = ball.right < box("bar").left; // else the sphere stands above the buttons
    const above = (beside ? box("bar") : ball).top - MARGIN;
    return { top: under * perPixel, high: Math.max(1, (above - under) * perPixel) };
  }

  draw() {
    if (!this.pixels) return;
    const { width, height } = this.scene, { scale, right, up } = this.view, pen = canvas.getContext("2d");
    const { top, high } = this.stage(), side = Math.min(canvas.width, canvas.height);
    const fit = scale * Math.min(canvas.width / width, high / height);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.imageSmoothingQuality = "high";
    pen.drawImage(this.picture, canvas.width / 2 - side * right - (fit * width) / 2, top + high / 2 + side * up - (fit * height) / 2,
                  fit * width, fit * height);
  }

  /** As of other kinds of models: for pages that embed this one, and for tests. */
  interface() {
    return {
      figures: () => ({ state: document.body.dataset.state, ...this.figures }),
      /** The picture in a light at that place, or from there: RGBA, top row first. */
      lightFrom: (place) => new Promise((resolve) => {
        this.turned = true;
        this.waiting.push(resolve);
        this.lightAt(place);
      }),
    };
  }
}

export function startRelitPicture() {
  const shown = new RelitPicture();
  window.sheen = shown.interface();
  shown.start();
}
