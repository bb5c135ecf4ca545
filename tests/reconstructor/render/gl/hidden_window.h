// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "tests/reconstructor/render/gl/synthetic_light_field.h"

namespace sheen {

inline constexpr int kWidth = 480, kHeight = 360;

/// A window that nobody sees, rebuilt for each test; skipped where there is no display or no OpenGL 3.3.
class Window : public testing::Test {
 protected:
  void SetUp() override {
    if (!open({})) GTEST_SKIP() << why_not_;
  }
  bool open(const DrawerOptions& renderer) {
    window_.reset();
    try {
      window_ = std::make_unique<ViewerWindow>(
          surface_light_field_kind(),
          ViewerOptions{.width = kWidth, .height = kHeight, .visible = false, .samples = 1, .drawer = renderer});
    } catch (const DeviceError& error) {
      why_not_ = error.what();
      return false;
    }
    window_->controls().panels = false;
    return true;
  }
  ViewerState state_of(std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot) {
    ViewerState state;
    state.snapshot = std::move(snapshot);
    return state;
  }
  ImageU8 draw(std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot) {
    return window_->draw_once(state_of(std::move(snapshot)));
  }

  std::unique_ptr<ViewerWindow> window_;
  std::string why_not_;
};

/// Pixels whose 3x3 neighbourhood lies on one smooth piece of the front: no outline runs through it.
inline ImageU8 interior(const std::vector<Hit>& hits, double jump) {
  ImageU8 mask(kWidth, kHeight, 1);
  for (int y = 1; y + 1 < kHeight; ++y)
    for (int x = 1; x + 1 < kWidth; ++x) {
      const Hit& middle = hits[y * kWidth + x];
      bool inside = middle && middle.front;
      for (int dy = -1; dy <= 1 && inside; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const Hit& other = hits[(y + dy) * kWidth + x + dx];
          inside &= other && other.front && std::abs(other.distance - middle.distance) < jump;
        }
      mask.at(x, y) = inside ? 255 : 0;
    }
  return mask;
}

inline int largest_difference(const ImageU8& a, const ImageU8& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a.data()[i] - b.data()[i]));
  return largest;
}

}  // namespace sheen
