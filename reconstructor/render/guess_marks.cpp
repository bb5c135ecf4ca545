// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/guess_marks.h"

#include <cmath>

#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

// As the window's shader has them.
constexpr float kImputedTint = 0.5f, kUnseenTint = 0.35f, kStripeTint = 0.8f;

bool in_stripe(int x, int y) {
  constexpr int kPeriod = 12;
  return (x + y) % kPeriod >= kPeriod / 2;
}

void tint(std::uint8_t* rgb, SampleState state, float part) {
  const Eigen::Vector3f color = 255 * state_color(state);
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<std::uint8_t>(std::lround((1 - part) * static_cast<float>(rgb[c]) + part * color[c]));
}

}  // namespace

Eigen::Vector3f state_color(SampleState state) {
  switch (state) {  // told apart by colour-blind people too (Okabe and Ito)
    case SampleState::kUnseen:
      return {0.80f, 0.47f, 0.65f};
    case SampleState::kImputed:
      return {0.34f, 0.71f, 0.91f};
    case SampleState::kMeasured:
      break;
  }
  return {1, 1, 1};
}

Eigen::Vector3f evidence_color(ShapeEvidence evidence) {
  switch (evidence) {
    case ShapeEvidence::kSeen:
      return {0.18f, 0.66f, 0.38f};
    case ShapeEvidence::kOutline:
      return {0.34f, 0.71f, 0.91f};
    case ShapeEvidence::kGuessed:
      break;
  }
  return {0.84f, 0.37f, 0.00f};
}

void mark_guesses(const PaintedView& view, ImageU8& picture) {
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const std::uint8_t coverage = view.coverage.at(x, y);
      if (coverage == kCoverageImputed) tint(picture.pixel(x, y), SampleState::kImputed, kImputedTint);
      if (coverage == kCoverageUnseen)
        tint(picture.pixel(x, y), SampleState::kUnseen, in_stripe(x, y) ? kStripeTint : kUnseenTint);
    }
}

}  // namespace sheen
