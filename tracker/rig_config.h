// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/stage/stage_layout.h"
#include "tracker/lights/frame_lights.h"
#include "tracker/pose/keyframe_gate.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// What a rig's file says of one camera.
struct CameraConfig {
  std::string name;  ///< letters, digits, - and _; empty where the rig has one camera and no [[cameras]]
  std::optional<Camera> camera;
  bool still = false;
  std::optional<Photometry> photometry;  ///< of the camera's file, where that has one
  std::optional<LightOptions> light;
  std::optional<std::string> source_uri;
  SourceSettings source;
  GateOptions gate;
};

/// What a rig's TOML file says. Paths are relative to the file.
///
///   [camera]  file                           what `sheen-tracker calibrate` wrote; or, in its place,
///             width height fx fy cx cy       pixels, integer coordinates at pixel centres; all required
///             lens = "opencv" | "fisheye"    distortion = [k1, k2, p1, p2, k3] or [k1, k2, k3, k4]
///             still                          true: the camera does not move; beside either
///   [stage]   file                           the layout of the tags
///   [light]   table index | first_frame      positions of lamps and which lit which frame
///             tag tag_size_m offset          or a lamp that carries a tag
///   [source]  uri frame_rate_hz exposure_us gain_db black_level white_balance pixel_format
///   [link]    endpoint keys allow            keys: the .key file; allow: the public keys that may connect
///   [gate]    min_tags max_blur_px max_overexposed min_bright min_angle_deg min_distance_m max_uncertainty_px
///
/// Of several cameras each has an entry [[cameras]] with a `name` and a `camera`, `source`, `light` and `gate` of its
/// own: camera.file = "left.json", source.uri = "aravis:LEFT". What [source], [light] and [gate] say holds for all of
/// them, where an entry does not say otherwise.
struct RigConfig {
  std::vector<CameraConfig> cameras{1};  ///< one at least
  std::optional<std::filesystem::path> stage_file;
  std::string endpoint = "tcp://127.0.0.1:7410";
  std::filesystem::path keys, allow;  ///< empty: none
};

/// Throws ConfigError naming file, line and key (unknown keys too), FileError when the file cannot be read.
RigConfig load_rig_config(const std::filesystem::path& file);

/// The camera of this name, or the only one where `name` is empty. Throws ConfigError that lists the names.
CameraConfig& camera_named(RigConfig& config, const std::string& name);

}  // namespace sheen
