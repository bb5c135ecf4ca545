// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/picture_drawer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sheen {
namespace {

constexpr double kPieceMs = 30;  // for which the mouse may wait
constexpr int kFirstPieces = 8;  // of a picture while it is not known what one takes
constexpr int kLeastRows = 16;

/// Milliseconds that drawing took, with all that OpenGL has put off.
class DrawingTime {
 public:
  double elapsed() const {
    glFinish();
    return std::chrono::duration<double, std::milli>(Clock::now() - begun_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begun_ = Clock::now();
};

}  // namespace

void PictureDrawer::resize(int width, int height) {
  if (target_ && target_->width() == width && target_->height() == height) return;
  target_.reset();
  coarse_.reset();
  target_.emplace(width, height, samples_);
  restart();
}

bool PictureDrawer::draw_soon(const ViewerState& state, const ViewControls& controls) {
  restart();
  if (pacer_.finest() || controls.mode == ViewMode::kCamera) {
    const DrawingTime time;
    draw_fine(state, controls);
    if (controls.mode != ViewMode::kCamera) pacer_.moved(time.elapsed());
    return true;
  }
  const MovingFrame frame = pacer_.frame();
  const auto part = [&](int size) { return static_cast<int>(std::ceil(size / frame.pixel)); };
  const int width = part(target_->width()), height = part(target_->height());
  if (!coarse_ || coarse_->width() != width || coarse_->height() != height) {
    coarse_.reset();
    coarse_.emplace(width, height, 1);
  }
  const DrawingTime time;
  scene_.draw_coarse(state, controls, *coarse_, *target_);
  pacer_.moved(time.elapsed());
  return false;
}

int PictureDrawer::rows_per_piece() const {
  const double pieces = pacer_.fine_ms() > 0 ? std::ceil(pacer_.fine_ms() / kPieceMs) : kFirstPieces;
  return std::max(kLeastRows, static_cast<int>(std::ceil(target_->height() / pieces)));
}

bool PictureDrawer::draw_piece(const ViewerState& state, const ViewControls& controls) {
  const DrawingTime time;
  const int rows = controls.mode == ViewMode::kCamera ? target_->height() : rows_per_piece();
  scene_.draw_rows(state, controls, *target_, rows_drawn_, rows);
  const bool last = rows_drawn_ + rows >= target_->height();
  if (last) target_->resolve();
  pieces_ms_ = (rows_drawn_ > 0 ? pieces_ms_ : 0) + time.elapsed();
  rows_drawn_ += rows;
  if (!last) return false;
  if (controls.mode != ViewMode::kCamera) pacer_.rested(pieces_ms_);
  restart();
  return true;
}

void PictureDrawer::draw_fine(const ViewerState& state, const ViewControls& controls) {
  scene_.draw_rows(state, controls, *target_, 0, target_->height());
  target_->resolve();
  restart();
}

}  // namespace sheen
