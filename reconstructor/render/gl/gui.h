// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

struct ImFont;
struct ImGuiContext;

namespace sheen {

/// What a hand does with the mouse over the panels, in pixels from the picture's top left corner.
struct Pointer {
  Eigen::Vector2f at{-1, -1};
  bool pressed = false;  ///< its left button
  float wheel = 0;       ///< steps since it was last asked
};

/// Dear ImGui with type and colours of our own, drawn with OpenGL 3.3. It knows no window: it is told of sizes and of
/// the pointer. Made, used and destroyed with one context current.
class Gui {
 public:
  Gui();
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  /// Starts a layout for a picture of this size in pixels. `scale`: pixels for what is one on a screen of ordinary
  /// density.
  void begin(int width, int height, float scale, const Pointer& pointer);
  void end();
  /// What the last layout has, into the framebuffer that is bound.
  void draw();

  float scale() const { return scale_; }
  ImFont* body() const { return body_; }
  ImFont* sentence() const { return sentence_; }  ///< for what comes first
  ImFont* large() const { return large_; }        ///< to be read from afar

 private:
  void load_fonts();

  struct ContextDeleter {
    void operator()(ImGuiContext* context) const;
  };
  std::unique_ptr<ImGuiContext, ContextDeleter> context_;
  float scale_ = 0;
  ImFont *body_ = nullptr, *sentence_ = nullptr, *large_ = nullptr;
};

}  // namespace sheen
