// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "reconstructor/render/gl/panel_words.h"
#include "reconstructor/render/gl/sketch.h"

struct ImDrawList;

namespace sheen {

// What is drawn by hand, for the files that know Dear ImGui.

/// As Dear ImGui has colours.
inline std::uint32_t packed(const Rgba& c) {
  return c[0] | c[1] << 8 | c[2] << 16 | std::uint32_t(c[3]) << 24;
}

/// `scale`: see `Gui::begin`.
void draw_sketch(const Sketch& sketch, float scale, ImDrawList& list);
/// A sphere lit by the light, with the lights of the images on it.
void draw_light_ball(const ShownLight& light, const Eigen::Vector2f& middle, float radius, ImDrawList& list);

}  // namespace sheen
