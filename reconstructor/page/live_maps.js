// SPDX-License-Identifier: Apache-2.0
// A light field that grows: what the reconstructor sends of it (LightFieldStream), on its way to the graphics.

const NOTHING_KNOWN = 0xffffffff;
const PLACE_NUMBERS = 12; // per triangle: PageModel::places
const FIRST_ROOM = 1 << 21; // texels

/** Tables of numbers, one behind the other. */
class Tables {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  next(Numbers, count) {
    const table = new Numbers(this.bytes, this.at, count);
    this.at += table.byteLength;
    return table;
  }
}

/** Ranges of a growing room, the first gap that is large enough. */
class Room {
  constructor() {
    this.size = 0;
    this.gaps = []; // [first, end), ascending
  }

  extend(size) {
    this.release(this.size, size - this.size);
    this.size = size;
  }

  /** The first of so many, or -1. */
  take(count) {
    const i = this.gaps.findIndex(([first, end]) => end - first >= count);
    if (i < 0) return -1;
    const gap = this.gaps[i], first = gap[0];
    gap[0] += count;
    if (gap[0] === gap[1]) this.gaps.splice(i, 1);
    return first;
  }

  release(first, count) {
    if (count === 0) return;
    let i = this.gaps.findIndex((gap) => gap[0] > first);
    if (i < 0) i = this.gaps.length;
    this.gaps.splice(i, 0, [first, first + count]);
    for (let k = Math.min(i + 1, this.gaps.length - 1); k >= Math.max(1, i); --k)
      if (this.gaps[k - 1][1] === this.gaps[k][0]) {
        this.gaps[k - 1][1] = this.gaps[k][1];
        this.gaps.splice(k, 1);
      }
  }
}

/** LightFieldStream::scene */
export function readScene(bytes) {
  const tables = new Tables(bytes);
  const [format, number, vertices, triangles, patches, columns, samples, edges] = tables.next(Uint32Array, 8);
  if (format !== 2) throw new Error("This page is older than the reconstructor: load it again.");
  return { number, columns, samples, scene: tables.next(Float64Array, 14), vertices: tables.next(Float32Array, 3 * vertices),
           triangles: tables.next(Uint32Array, 3 * triangles), edges: tables.next(Uint32Array, edges),
           placed: tables.next(Uint32Array, 6 * triangles), patches: tables.next(Uint32Array, 2 * patches) };
}

export class LiveMaps {
  /** `scene`: of `readScene`. */
  constructor({ number, columns, samples, triangles, placed, patches }) {
    const count = patches.length / 2;
    this.scene = number;
    this.columns = columns;
    this.samples = samples;
    this.patches = Array.from({ length: count }, (_, p) => ({
      samples: patches[2 * p], column: patches[2 * p + 1], end: p + 1 < count ? patches[2 * p + 3] : columns,
      triangles: [], terms: 0, known: false, first: 0, room: 0, means: null, amounts: null }));
    let sample = 0;
    for (const patch of this.patches) {
      patch.sample = sample;
      sample += patch.samples;
    }
    this.places = new Uint32Array(PLACE_NUMBERS * (triangles.length / 3));
    this.floats = new Float32Array(this.places.buffer);
    this.firstInPatch = new Uint32Array(triangles.length / 3);
    for (let t = 0; t < this.firstInPatch.length; ++t) {
      const [of, first, side, a, b, c] = placed.subarray(6 * t, 6 * t + 6), patch = this.patches[of];
      patch.triangles.push(t);
      this.firstInPatch[t] = first;
      this.places.set([...triangles.subarray(3 * t, 3 * t + 3), side, a, b, c, patch.sample + first, 0, NOTHING_KNOWN],
                      PLACE_NUMBERS * t);
    }
    this.room = new Room();
    this.stride = 0;
    this.coefficients = new Float32Array(0);
    this.begun = false;
  }

  /** What an answer begins with. */
  told(bytes) {
    const [, scene, changes, more, patches, seen, , , waitedMs] = new Uint32Array(bytes, 0, 9);
    return { scene, changes, more: more === 1, seen: seen === 1, empty: patches === 0 && seen === 0, waitedMs };
  }

  /** LightFieldStream::changes_for, into the graphics. Returns the cameras where they are told. */
  put(bytes, viewer) {
    const tables = new Tables(bytes), [, , , , patches, seen, cameras] = tables.next(Uint32Array, 7);
    const [exposure] = tables.next(Float32Array, 1);
    tables.next(Uint32Array, 1);
    if (!this.begun) viewer.setRooms(this.samples, FIRST_ROOM);
    if (!this.begun) this.room.extend(FIRST_ROOM);
    this.begun = true;
    if (seen === 1) this.putSeen(tables);
    for (let n = 0; n < patches; ++n) this.putPatch(tables, viewer);
    if (patches > 0) viewer.setPlaces(this.places);
    viewer.coloured = this.patches.some((patch) => patch.known);
    viewer.setCoefficients(this.coefficients, this.stride, exposure);
    return cameras > 0 ? tables.next(Float32Array, 14 * cameras) : null;
  }

  putSeen(tables) {
    const held = tables.next(Uint32Array, Math.ceil(this.patches.length / 32));
    this.patches.forEach((patch, p) => {
      if ((held[p >>> 5] >>> (p & 31)) & 1) this.putCoefficients(patch, tables);
    });
  }

  putPatch(tables, viewer) {
    const [number, terms] = tables.next(Uint32Array, 2), [low, width] = tables.next(Float32Array, 2);
    const patch = this.patches[number];
    patch.known = terms !== NOTHING_KNOWN;
    patch.terms = patch.known ? terms : 0;
    patch.means = tables.next(Float32Array, patch.terms).slice();
    patch.amounts = tables.next(Float32Array, patch.terms).slice();
    this.widen(patch.terms);
    this.putCoefficients(patch, tables);
    viewer.write("means", patch.sample, tables.next(Uint8Array, 4 * patch.samples));
    this.makeRoom(patch, patch.samples * patch.terms, viewer);
    viewer.write("basis", patch.first, tables.next(Uint8Array, 4 * patch.samples * patch.terms));
    for (const t of patch.triangles) {
      const at = PLACE_NUMBERS * t;
      this.places[at + 8] = patch.first + this.firstInPatch[t] * patch.terms;
      this.places[at + 9] = patch.known ? patch.terms : NOTHING_KNOWN;
      this.floats[at + 10] = low;
      this.floats[at + 11] = width;
    }
  }

  putCoefficients(patch, tables) {
    const { terms, means, amounts } = patch, numbers = tables.next(Float32Array, (patch.end - patch.column) * terms);
    for (let i = 0, column = patch.column; column < patch.end; ++column)
      for (let r = 0; r < terms; ++r) this.coefficients[column * this.stride + r] = (numbers[i++] - means[r]) * amounts[r];
  }

  /** So many terms a column at least. */
  widen(terms) {
    if (terms <= this.stride) return;
    const wider = new Float32Array(this.columns * terms);
    for (let column = 0; column < this.columns; ++column)
      wider.set(this.coefficients.subarray(column * this.stride, (column + 1) * this.stride), column * terms);
    this.coefficients = wider;
    this.stride = terms;
  }

  makeRoom(patch, texels, viewer) {
    if (texels <= patch.room) return;
    this.room.release(patch.first, patch.room);
    for (let first = -1; first < 0; patch.first = first) {
      first = this.room.take(texels);
      if (first < 0) this.room.extend(viewer.growBasis(Math.max(this.room.size + texels, 1.5 * this.room.size)));
    }
    patch.room = texels;
  }
}
