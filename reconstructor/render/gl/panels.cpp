// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "reconstructor/render/gl/light_ball.h"
#include "reconstructor/render/gl/panel_drawings.h"

namespace sheen {
namespace {

constexpr ImU32 kGood = IM_COL32(70, 192, 122, 255), kBusy = IM_COL32(63, 184, 195, 255),
                kWarn = IM_COL32(255, 190, 70, 255), kBad = IM_COL32(240, 100, 124, 255),
                kIdle = IM_COL32(134, 149, 162, 255), kTrack = IM_COL32(70, 78, 86, 255),
                kLit = IM_COL32(14, 124, 134, 255), kAlarm = IM_COL32(150, 20, 16, 235);
constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_NoMove;

ImU32 light_of(Tone tone) {
  switch (tone) {
    case Tone::kGood:
      return kGood;
    case Tone::kBusy:
      return kBusy;
    case Tone::kWarn:
      return kWarn;
    case Tone::kBad:
      return kBad;
    case Tone::kIdle:
      break;
  }
  return kIdle;
}

ImVec2 at(const Eigen::Vector2f& place) {
  return {place.x(), place.y()};
}

void text(const std::string& words) {
  ImGui::TextUnformatted(words.c_str(), words.c_str() + words.size());
}

void text(const std::string& words, ImU32 color) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  text(words);
  ImGui::PopStyleColor();
}

void dim_text(const std::string& words) {
  text(words, ImGui::GetColorU32(ImGuiCol_TextDisabled));
}

/// One layout of all panels.
class Layout {
 public:
  Layout(const Gui& gui, const PanelContent& content, int width, int height)
      : gui_(gui),
        content_(content),
        told_(content.told),
        width_(static_cast<float>(width)),
        height_(static_cast<float>(height)),
        margin_(10 * gui.scale()) {}

  void add_all() {
    add_buttons();
    add_card();
    add_notes();
    add_legend();
    add_light();
    add_trouble();
    if (content_.controls.help) add_keys();
  }

  PanelEvents events;
  std::vector<Panel> places;

 private:
  /// A panel with its corner or side `pivot` (0..1 each way) at a place. @return its size, to be used when it is full.
  template <typename Fill>
  ImVec2 panel(const char* name, ImVec2 place, ImVec2 pivot, Fill&& fill) {
    ImGui::SetNextWindowPos(place, ImGuiCond_Always, pivot);
    ImGui::SetNextWindowSizeConstraints({0, 0}, {width_ - 2 * margin_, height_ - 2 * margin_});
    ImGui::Begin(name, nullptr, kPanel);
    fill();
    const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    ImGui::End();
    places.push_back({static_cast<int>(corner.x), static_cast<int>(corner.y), static_cast<int>(std::ceil(size.x)),
                      static_cast<int>(std::ceil(size.y))});
    return size;
  }

  bool button(const ActionWords& words, const char* name) {
    const bool matters = sheen::matters(words.action, content_.controls);
    const bool lit = matters && words.action != ViewAction::kDetails && is_on(words.action, content_.controls);
    ImGui::BeginDisabled(!matters);
    if (lit) ImGui::PushStyleColor(ImGuiCol_Button, kLit);
    const bool is_pressed = ImGui::Button(name);
    if (lit) ImGui::PopStyleColor();
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered()) add_tip(words.says, std::string("key ") + words.key);
    if (is_pressed) events.pressed.push_back(words.action);
    return is_pressed;
  }

  /// Above the button, or below one at the top; whole.
  void add_tip(const std::string& says, const std::string& keys) const {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const bool above = low.y > height_ / 2;
    const float half = std::max(ImGui::CalcTextSize(says.c_str()).x, ImGui::CalcTextSize(keys.c_str()).x) / 2 +
                       ImGui::GetStyle().WindowPadding.x;
    const float middle = std::max(half + margin_, std::min((low.x + high.x) / 2, width_ - half - margin_));
    ImGui::SetNextWindowPos({middle, above ? low.y - margin_ : high.y + margin_}, ImGuiCond_Always,
                            {0.5f, above ? 1.0f : 0.0f});
    ImGui::BeginTooltip();
    text(says);
    dim_text(keys);
    ImGui::EndTooltip();
  }

  bool offers(ViewAction action) const { return std::ranges::find(content_.offered, action) != content_.offered.end(); }

  const char* name_of(const ActionWords& words) const {
    if (words.action != ViewAction::kQuit || !content_.state.figures) return words.button;
    return content_.state.work ? "End now" : "Finish";
  }

  /// As many in a row as there is room for.
  void add_buttons() {
    const ImGuiStyle& style = ImGui::GetStyle();
    const auto opens_group = [](ViewAction action) {
      return action == ViewAction::kReasons || action == ViewAction::kReset || action == ViewAction::kUndo ||
             action == ViewAction::kHelp;
    };
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {6 * gui_.scale(), 6 * gui_.scale()});
    bottom_ = panel("buttons", {width_ / 2, height_ - margin_}, {0.5f, 1},
                    [&] {
                      const float room = width_ - 2 * margin_ - 2 * style.WindowPadding.x;
                      float used = 0;
                      for (const ActionWords& words : view_actions()) {
                        if (!offers(words.action) || words.action == ViewAction::kDetails) continue;
                        const float gap = style.ItemSpacing.x * (opens_group(words.action) ? 4.0f : 1.0f);
                        const float own = ImGui::CalcTextSize(name_of(words)).x + 2 * style.FramePadding.x;
                        if (used > 0 && used + gap + own <= room) {
                          ImGui::SameLine(0, gap);
                          used += gap + own;
                        } else {
                          used = own;
                        }
                        button(words, name_of(words));
                      }
                    })
                  .y +
              2 * margin_;
    ImGui::PopStyleVar();
  }

  /// An arrow to where the camera should go, or a dot where it is there.
  void add_arrow() {
    const float line = ImGui::GetTextLineHeight(), half = 0.5f * line;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const Eigen::Vector2f middle(corner.x + half, corner.y + half);
    if (told_.way->isZero()) {
      list.AddCircleFilled(at(middle), 0.45f * half, kGood);
    } else {
      const Eigen::Vector2f along(half * told_.way->x(), -half * told_.way->y()), side(-along.y(), along.x());
      list.AddLine(at(middle - along), at(middle + 0.2f * along), kGood, 0.4f * half);
      list.AddTriangleFilled(at(middle + along), at(middle + 0.75f * side), at(middle - 0.75f * side), kGood);
    }
    ImGui::Dummy({line, line});
    ImGui::SameLine(0, 0.4f * line);
  }

  void add_bar(double fraction) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(std::min(320 * gui_.scale(), width_ - 6 * margin_), 8 * gui_.scale());
    const float done = size.x * static_cast<float>(std::clamp(fraction, 0.0, 1.0));
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, kTrack);
    if (done >= 1) list.AddRectFilled(corner, {corner.x + done, corner.y + size.y}, kGood);
    ImGui::Dummy(size);
  }

  void add_details() {
    if (!ImGui::BeginTable("details", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX)) return;
    for (const ToldLine& line : told_.details) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      dim_text(line.label);
      ImGui::TableNextColumn();
      if (line.tone == Tone::kIdle)
        text(line.value);
      else
        text(line.value, light_of(line.tone));
    }
    ImGui::EndTable();
  }

  void add_card() {
    card_ = panel("card", {margin_, margin_}, {0, 0}, [&] {
      ImGui::PushTextWrapPos(std::min(0.7f * width_, 560 * gui_.scale()));
      ImGui::PushFont(gui_.sentence());
      const float line = ImGui::GetTextLineHeight();
      const ImVec2 corner = ImGui::GetCursorScreenPos();
      ImGui::GetWindowDrawList()->AddCircleFilled({corner.x + line / 2, corner.y + line / 2}, 0.36f * line,
                                                  light_of(told_.tone));
      ImGui::Dummy({line, line});
      ImGui::SameLine(0, 0.4f * line);
      text(told_.sentence);
      ImGui::PopFont();
      if (content_.state.work) add_bar(content_.state.work->fraction);
      if (!told_.next.empty()) {
        if (told_.way) add_arrow();
        text(told_.next);
      }
      if (!told_.counts.empty()) dim_text(told_.counts);
      if (content_.controls.details) add_details();
      if (offers(ViewAction::kDetails)) {
        ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 2 * gui_.scale()});
        button(words_of(ViewAction::kDetails), content_.controls.details ? "Less" : "Details");
        ImGui::PopStyleVar();
      }
      ImGui::PopTextWrapPos();
    });
  }

  /// At the top right, or below what comes first where there is no room beside it.
  void add_notes() {
    if (told_.notes.empty()) return;
    const float longest = 460 * gui_.scale(), rim = 2 * ImGui::GetStyle().WindowPadding.x;
    float widest = 0;
    for (const std::string& note : told_.notes)
      widest = std::max(widest, std::min(longest, ImGui::CalcTextSize(note.c_str()).x));
    const bool beside = card_.x + widest + rim + 3 * margin_ <= width_;
    const ImVec2 place = beside ? ImVec2(width_ - margin_, margin_) : ImVec2(margin_, card_.y + 2 * margin_);
    panel("notes", place, {beside ? 1.0f : 0.0f, 0}, [&] {
      ImGui::PushTextWrapPos(std::min(longest + rim, width_ - 2 * margin_));
      for (const std::string& note : told_.notes) text(note, kWarn);
      ImGui::PopTextWrapPos();
    });
  }

  void add_legend() {
    if (told_.legend.empty()) return;
    panel("legend", {width_ - margin_, height_ - bottom_}, {1, 1}, [&] {
      if (!told_.legend_title.empty()) dim_text(told_.legend_title);
      const float line = ImGui::GetTextLineHeight(), side = 0.75f * line;
      for (const Swatch& swatch : told_.legend) {
        const auto [x, y] = ImGui::GetCursorScreenPos();
        const float top = std::round(y + (line - side) / 2);
        ImGui::GetWindowDrawList()->AddRectFilled({x, top}, {x + side, top + side}, packed(swatch.color),
                                                  3 * gui_.scale());
        ImGui::Dummy({side, line});
        ImGui::SameLine(0, 0.6f * line);
        text(swatch.text);
      }
    });
  }

  /// A small sphere that shows where the light comes from, and is dragged.
  void add_light() {
    if (!told_.light) return;
    panel("light", {margin_, height_ - bottom_}, {0, 1}, [&] {
      const float side = std::round(110 * gui_.scale()), radius = side / 2 - 1;
      const ImVec2 corner = ImGui::GetCursorScreenPos();
      const Eigen::Vector2f middle(corner.x + side / 2, corner.y + side / 2);
      draw_light_ball(*told_.light, middle, radius, *ImGui::GetWindowDrawList());
      ImGui::InvisibleButton("ball", {side, side});
      if (ImGui::IsItemActive()) {
        const auto [x, y] = ImGui::GetIO().MousePos;
        events.light = told_.light->axes.transpose() * light_at({(x - middle.x()) / radius, (middle.y() - y) / radius});
      }
      if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
        add_tip(light_in_words(told_.light->now), "drag, or Ctrl and arrows");
    });
  }

  /// In the upper half, to be read from afar.
  void add_trouble() {
    if (content_.state.trouble.empty()) return;
    ImGui::PushStyleColor(ImGuiCol_WindowBg, kAlarm);
    ImGui::PushFont(gui_.large());
    panel("trouble", {width_ / 2, 0.28f * height_}, {0.5f, 0}, [&] {
      ImGui::PushTextWrapPos(0.9f * width_);
      text(content_.state.trouble);
      ImGui::PopTextWrapPos();
    });
    ImGui::PopFont();
    ImGui::PopStyleColor();
  }

  void add_keys() {
    constexpr std::pair<const char*, const char*> kHand[] = {
        {"drag, arrows", "rotate"},
        {"right drag, Shift", "move"},
        {"wheel, + and -", "nearer, farther"},
        {"Ctrl and either", "turn the light, where a model knows moving light"}};
    panel("keys", {width_ / 2, height_ / 2}, {0.5f, 0.5f}, [&] {
      if (!ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX)) return;
      const auto row = [](const std::string& key, const std::string& says) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        dim_text(key);
        ImGui::TableNextColumn();
        text(says);
      };
      for (const ActionWords& words : view_actions())
        if (offers(words.action)) row({words.key}, std::string(words.button) + ": " + words.says);
      for (const auto& [hand, says] : kHand) row(hand, says);
      ImGui::EndTable();
    });
  }

  const Gui& gui_;
  const PanelContent& content_;
  const Told& told_;
  float width_, height_, margin_;
  float bottom_ = 0;  ///< what the buttons take of the height
  ImVec2 card_;       ///< size
};

}  // namespace

PanelEvents Panels::lay_out_once(const PanelContent& content, int width, int height, float scale,
                                 const Pointer& pointer) {
  gui_.begin(width, height, scale, pointer);
  for (const Sketch& sketch : content.sketches) draw_sketch(sketch, scale, *ImGui::GetBackgroundDrawList());
  Layout layout(gui_, content, width, height);
  if (content.controls.panels) layout.add_all();
  gui_.end();
  places_ = std::move(layout.places);
  return std::move(layout.events);
}

PanelEvents Panels::lay_out(const PanelContent& content, int width, int height, float scale, const Pointer& pointer) {
  PanelEvents events = lay_out_once(content, width, height, scale, pointer);
  // Panels that are new, or of a new size, know their size only now.
  lay_out_once(content, width, height, scale, {pointer.at, pointer.pressed});
  return events;
}

bool Panels::cover(const Eigen::Vector2f& place) const {
  return std::ranges::any_of(places_, [&](const Panel& p) {
    const auto x = static_cast<int>(place.x()), y = static_cast<int>(place.y());
    return x >= p.x && y >= p.y && x < p.x + p.width && y < p.y + p.height;
  });
}

}  // namespace sheen
