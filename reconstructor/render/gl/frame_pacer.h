// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// How a moving picture is drawn.
struct MovingFrame {
  double pixel = 1;    ///< size of its pixels in those of the window, each way
  bool smooth = true;  ///< several samples per pixel, as a picture at rest has them
};

/// How coarse frames must be so that a moving picture follows the hand, learnt from what frames took. While something
/// moves it becomes coarser only, so that nothing flickers; finer between two movements.
class FramePacer {
 public:
  static constexpr double kGoalMs = 50;   ///< of a frame while something moves
  static constexpr double kLimitMs = 66;  ///< above this it is too slow: 15 frames per second

  /// Of the next frame of a movement.
  MovingFrame frame() const;
  bool finest() const { return level_ == 0; }  ///< as fine as at rest
  /// What such a frame took, from the first call to the last pixel.
  void moved(double frame_ms);
  /// A whole picture as fine as it can be took this long. The movement, if there was one, is over.
  void rested(double picture_ms);
  /// What the next fine picture will take; 0 where none has been drawn yet.
  double fine_ms() const { return fine_ms_; }

 private:
  int level_ = 4;        ///< of the first frame of all: something is to be seen soon
  double least_ms_ = 0;  ///< of this movement's frames at this level; 0: none yet
  int slow_frames_ = 0;  ///< one after the other
  double fine_ms_ = 0;
};

}  // namespace sheen
