// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "reconstructor/render/gl/panel.h"

namespace sheen {

using Rgba = std::array<std::uint8_t, 4>;  ///< sRGB-encoded, alpha not premultiplied

/// What is to be drawn over a part of a picture, behind the panels: places are in pixels from the picture's top left
/// corner; widths are those on a screen of ordinary density.
struct Sketch {
  struct Line {
    Eigen::Vector2f from, to;
    float width;
    Rgba color;
  };
  struct Mark {  ///< a diamond with a word on its right
    Eigen::Vector2f at;
    std::string text;
    Rgba color;
  };
  struct Label {  ///< a word round a place, on a dark ground
    Eigen::Vector2f at;
    std::string text;
    Rgba color;
  };
  Panel clip;  ///< nothing is drawn outside
  std::vector<Line> lines = {};
  std::vector<Mark> marks = {};
  std::vector<Label> labels = {};
};

}  // namespace sheen
