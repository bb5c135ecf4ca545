// SPDX-License-Identifier: Apache-2.0
// How coarse frames must be so that a moving picture follows the hand, learnt from what frames took: as in the window.
// While something moves it becomes coarser only, so that nothing flickers; finer between two movements.

const GOAL_MS = 50; // of a frame while something moves
const LIMIT_MS = 66; // above this it is too slow: 15 frames per second
/** From fine to coarse: size of pixels in those of the picture, and whether there are several samples in each. */
const LEVELS = [{ pixel: 1, smooth: true }, { pixel: 1 }, { pixel: 1.5 }, { pixel: 2 }, { pixel: 3 }, { pixel: 4 }];
const COARSEST = LEVELS.length - 1;
const FRACTION_OF_ONE_SAMPLE = 0.3; // of the time of a smooth picture, which is one with and one without several samples
const SLOW_FRAMES = 2; // of which one alone is an accident

const cost = ({ pixel, smooth }) => (smooth ? 1 : FRACTION_OF_ONE_SAMPLE) / (pixel * pixel);

function finestWithinGoal(level, ms) {
  let finest = 0;
  while (finest < COARSEST && (ms * cost(LEVELS[finest])) / cost(LEVELS[level]) > GOAL_MS) ++finest;
  return finest;
}

export class Pacer {
  constructor() {
    this.level = 4; // of the first frame of all: something is to be seen soon
    this.leastMs = 0; // of this movement's frames at this level; 0: none yet
    this.slowFrames = 0;
    this.fineMs = 0; // of the last fine picture; 0: there is none yet
  }

  frame() {
    return LEVELS[this.level];
  }

  /** Such a frame took so long, until its last pixel was there. */
  moved(ms) {
    this.leastMs = this.leastMs > 0 ? Math.min(this.leastMs, ms) : ms;
    this.slowFrames = ms > LIMIT_MS ? this.slowFrames + 1 : 0;
    if (this.slowFrames < SLOW_FRAMES || this.level === COARSEST) return;
    this.level = Math.max(this.level + 1, finestWithinGoal(this.level, ms));
    this.slowFrames = 0;
    this.leastMs = 0;
  }

  /** A fine picture took so long. The movement, if there was one, is over. */
  rested(ms) {
    const byPicture = finestWithinGoal(0, ms);
    if (this.fineMs === 0 || byPicture === 0) this.level = byPicture;
    else if (this.leastMs > 0) this.level = Math.min(this.level, finestWithinGoal(this.level, this.leastMs));
    this.fineMs = ms;
    this.leastMs = 0;
    this.slowFrames = 0;
  }
}
