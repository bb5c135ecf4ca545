// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panel_drawings.h"

#include <imgui.h>

#include <cmath>

namespace sheen {
namespace {

constexpr ImU32 kShadow = IM_COL32(0, 0, 0, 150);

ImVec2 at(const Eigen::Vector2f& place) {
  return {place.x(), place.y()};
}

}  // namespace

void draw_sketch(const Sketch& sketch, float scale, ImDrawList& list) {
  const Panel& clip = sketch.clip;
  list.PushClipRect({static_cast<float>(clip.x), static_cast<float>(clip.y)},
                    {static_cast<float>(clip.x + clip.width), static_cast<float>(clip.y + clip.height)});
  for (const auto& [from, to, width, tint] : sketch.lines) list.AddLine(at(from), at(to), packed(tint), width * scale);
  const float line = ImGui::GetTextLineHeight();
  for (const auto& [place, word, tint] : sketch.marks) {
    const float r = 0.4f * line;
    const auto [x, y] = at(place);
    list.AddQuadFilled({x - r, y}, {x, y - r}, {x + r, y}, {x, y + r}, packed(tint));
    list.AddText({x + 1.5f * r, y - line / 2}, packed(tint), word.c_str());
  }
  for (const auto& [place, word, tint] : sketch.labels) {
    const ImVec2 size = ImGui::CalcTextSize(word.c_str());
    const float x = std::round(place.x() - size.x / 2), y = std::round(place.y() - size.y / 2), rim = 3 * scale;
    list.AddRectFilled({x - rim, y}, {x + size.x + rim, y + size.y}, kShadow, rim);
    list.AddText({x, y}, packed(tint), word.c_str());
  }
  list.PopClipRect();
}

void draw_light_ball(const ShownLight& light, const Eigen::Vector2f& middle, float radius, ImDrawList& list) {
  constexpr int kRings = 40;
  constexpr ImU32 kRim = IM_COL32(14, 124, 134, 255), kImage = IM_COL32(14, 124, 134, 150);
  const auto place = [&](const Eigen::Vector3d& direction) -> Eigen::Vector2f {
    return middle + radius * Eigen::Vector2d(direction.x(), -direction.y()).cast<float>();
  };
  const Eigen::Vector2f spot = place(light.now);
  for (int ring = kRings; ring > 0; --ring) {  // from the dark rim to the spot, each inside the one before
    const float part = static_cast<float>(ring) / kRings, shine = (1 - part) * (1 - part);
    const auto level = [&](float dark, float bright) { return static_cast<int>(dark + shine * (bright - dark)); };
    list.AddCircleFilled(at(spot + part * (middle - spot)), part * radius,
                         IM_COL32(level(52, 253), level(54, 251), level(58, 244), 255), 64);
  }
  for (const Eigen::Vector3d& image : light.images)
    if (image.z() > 0) list.AddCircleFilled(at(place(image)), 0.04f * radius, kImage);
  list.AddCircleFilled(at(spot), 0.13f * radius, IM_COL32_WHITE);
  list.AddCircle(at(spot), 0.13f * radius, kRim, 0, 0.05f * radius);
}

}  // namespace sheen
