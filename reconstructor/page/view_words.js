// SPDX-License-Identifier: Apache-2.0
// A view in words: from which side, and how far from the photographs.
import { dot, subtract, unit } from "./vectors.js";

const CAMERA_NUMBERS = 14; // PageModel::cameras
const SIDES = ["front", "front right", "right", "back right", "back", "back left", "left", "front left"];

/** Between the eye and the nearest photograph, seen from the middle of the object; NaN without photographs. */
export function nearestPhotographDeg(cameras, orbit) {
  const here = unit(subtract(orbit.eye(), orbit.centre));
  let most = cameras.length > 0 ? -1 : NaN;
  for (let i = 0; i < cameras.length; i += CAMERA_NUMBERS)
    most = Math.max(most, dot(here, unit(subtract(cameras.subarray(i, i + 3), orbit.centre))));
  return (Math.acos(Math.min(1, most)) * 180) / Math.PI;
}

/** "From the front right, above". The front is where the home view is from. */
export function viewName(orbit) {
  const home = orbit.homeDirection;
  const front = Math.atan2(dot(home, orbit.further), dot(home, orbit.across));
  const turned = (((orbit.azimuth - front) / (2 * Math.PI)) % 1 + 1) % 1;
  const side = SIDES[Math.round(turned * SIDES.length) % SIDES.length];
  const height = orbit.elevation > 0.9 ? ", from above" : orbit.elevation < -0.35 ? ", from below" : "";
  return `Seen from the ${side}${height}`;
}
