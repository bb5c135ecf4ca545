// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"

namespace sheen {

enum class Motion : std::uint8_t { kUnspecified = 0, kStill = 1, kMoves = 2 };

/// What changes between the images of a source: it decides which model they are for.
struct RigMotion {
  Motion camera = Motion::kUnspecified;
  Motion light = Motion::kUnspecified;
  bool operator==(const RigMotion&) const = default;
};

/// "the camera moves and the light stands still".
std::string in_words(const RigMotion& motion);

/// Finds out by looking at images one after the other: the camera (its lens, or where it stands against the object) and
/// the light stand still as long as all are the same, to a millionth.
class MotionWatch {
 public:
  void look(const PosedCamera& from, const LightState& light);
  /// Of the images so far; unspecified before the first.
  const RigMotion& motion() const { return motion_; }

 private:
  std::optional<PosedCamera> camera_;
  LightState light_;
  RigMotion motion_;
};

}  // namespace sheen
