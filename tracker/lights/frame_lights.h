// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/capture/capture.h"

namespace sheen {

/// Where a rig's light comes from: [light] of its file.
struct LightOptions {
  std::filesystem::path table;  ///< list of lights (.lp), in the frame of the stage: where a gantry's lamp can be
  std::filesystem::path index;  ///< which entry of it lit which frame: lines FRAME,ENTRY; ENTRY counts from 0
  std::optional<std::uint64_t> first_frame;  ///< without `index`: the id of the frame that the first entry lit
  std::optional<int> tag;                    ///< of the lamp that carries it
  double tag_size_m = 0;                     ///< side of its black square
  /// From the tag's centre to the lamp, metres: x to the right of the upright tag, y up, z out of its face.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
};
/// Empty, or what is wrong: "KEY must be ...".
std::string validation_error(const LightOptions& options);

/// Says in which light a frame was taken.
class FrameLights {
 public:
  struct Answer {
    std::optional<LightState> light;
    std::string refusal;  ///< where there is none: why, a short, stable word ("beyond_light_table", ...)
  };
  virtual ~FrameLights() = default;
  /// `frame`: with its id, its tags and its pose, which is usable.
  virtual Answer of(const Capture& frame) = 0;
  /// Whether it looks at tags that are not on the stage.
  virtual bool reads_tags() const { return false; }
};

/// Throws FileError naming the table or the index.
std::unique_ptr<FrameLights> make_frame_lights(const LightOptions& options);

}  // namespace sheen
