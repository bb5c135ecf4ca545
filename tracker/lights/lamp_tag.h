// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracker/lights/frame_lights.h"

namespace sheen {

/// A lamp that carries a tag of its own: its place follows from the tag's pose in the frame. Seen head-on, a tag hardly
/// shows its tilt, and one tag alone shows two poses, mirrored at the line of sight: where the lamp's place is so not
/// known to 5 mm (standard deviation), nothing is guessed. Refuses a
/// frame as "lamp_tag_not_seen", "lamp_tag_seen_twice", "lamp_tag_broken" (no pose fits) or "lamp_tag_uncertain".
class LampTag : public FrameLights {
 public:
  explicit LampTag(const LightOptions& options) : options_(options) {}
  Answer of(const Capture& frame) override;
  bool reads_tags() const override { return true; }

 private:
  LightOptions options_;
};

}  // namespace sheen
