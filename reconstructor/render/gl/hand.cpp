// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sheen {
namespace {

constexpr double kTurn_rad = 4;  // for a way as long as the picture is high
constexpr double kArrow = 0.02;  // of the picture's height
constexpr double kNearer = 0.9;  // of the distance

}  // namespace

bool Hand::point(const Eigen::Vector2f& place, int height, Modifiers modifiers) {
  const Eigen::Vector2d part = (place - pointer_.at).cast<double>() / std::max(1, height);
  pointer_.at = place;
  if (left_ && modifiers.control) return move(part, Does::kTurnsLight);
  if (other_ || (left_ && modifiers.shift)) return move(part, Does::kPans);
  return left_ && move(part, Does::kOrbits);
}

bool Hand::wheel(double steps, bool on_panel) {
  if (!on_panel) return dolly(std::pow(kNearer, steps));
  pointer_.wheel += static_cast<float>(steps);
  return false;
}

bool Hand::arrow(int right, int down, Modifiers modifiers) {
  return move(kArrow * Eigen::Vector2d(right, down), modifiers.control ? Does::kTurnsLight
                                                     : modifiers.shift ? Does::kPans
                                                                       : Does::kOrbits);
}

bool Hand::come_nearer(int steps) {
  return dolly(std::pow(kNearer, steps));
}

void Hand::press(Button button, bool on_panel) {
  if (!on_panel) (button == Button::kLeft ? left_ : other_) = true;
  if (!on_panel || button != Button::kLeft) return;
  pointer_.pressed = true;
  seen_ = released_ = false;
}

void Hand::release(Button button) {
  (button == Button::kLeft ? left_ : other_) = false;
  if (button != Button::kLeft) return;
  if (seen_)
    pointer_.pressed = false;
  else
    released_ = true;
}

bool Hand::looked_at() {
  pointer_.wheel = 0;
  seen_ = true;
  if (!std::exchange(released_, false)) return false;
  pointer_.pressed = false;
  return true;
}

bool Hand::move(const Eigen::Vector2d& part, Does what) {
  if (what == Does::kTurnsLight || (what == Does::kOrbits && holds_light_)) {
    controls_.turn_light(kTurn_rad * part.x(), -kTurn_rad * part.y());
    return true;
  }
  controls_.follow = false;
  if (what == Does::kPans)
    controls_.orbit.pan(-part.x(), part.y());
  else
    controls_.orbit.orbit(-kTurn_rad * part.x(), kTurn_rad * part.y());
  return true;
}

bool Hand::dolly(double factor) {
  controls_.follow = false;
  controls_.orbit.dolly(factor);
  return true;
}

}  // namespace sheen
