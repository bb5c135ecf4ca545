// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/render/gl/gui.h"
#include "reconstructor/render/gl/view_controls.h"

namespace sheen {

/// What a hand does with mouse and keyboard: over the picture it moves object or light, over a panel it is the panels'.
/// Knows no window. Places are in pixels of the picture.
class Hand {
 public:
  explicit Hand(ViewControls& controls) : controls_(controls) {}

  enum class Button { kLeft, kOther };
  struct Modifiers {
    bool shift = false, control = false;
  };
  /// For models whose picture is from one eye only: what would turn the object turns the light.
  void holds_light(bool holds) { holds_light_ = holds; }

  // Each tells whether the picture has moved.
  /// `height`: of the picture.
  bool point(const Eigen::Vector2f& place, int height, Modifiers modifiers);
  bool wheel(double steps, bool on_panel);
  /// Arrow keys: so many to the right and down.
  bool arrow(int right, int down, Modifiers modifiers);
  bool come_nearer(int steps);

  void press(Button button, bool on_panel);
  void release(Button button);

  /// For the panels.
  const Pointer& pointer() const { return pointer_; }
  /// After the panels have looked at `pointer`. True: they must look again, for a click was over before they looked.
  bool looked_at();

 private:
  enum class Does { kOrbits, kPans, kTurnsLight };
  bool move(const Eigen::Vector2d& part, Does what);
  bool dolly(double factor);

  ViewControls& controls_;
  bool holds_light_ = false;
  Pointer pointer_;
  bool seen_ = true, released_ = false;  ///< the panels have looked; the button is up since
  bool left_ = false, other_ = false;    ///< buttons that were pressed on the picture
};

}  // namespace sheen
