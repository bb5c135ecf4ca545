// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>

#include "tracker/sources/frame_source.h"

namespace sheen {

enum class SourceKind { kAravis, kVideo, kDataset };

/// `aravis:ID`, `video:PATH` (a file, or a V4L2 device as /dev/video0), `video:ADDRESS` (a live stream of the network,
/// `video:http://HOST:8080/video`) or `dataset:DIR`.
struct SourceUri {
  SourceKind kind = SourceKind::kAravis;
  std::string target;
};
SourceUri parse_source_uri(const std::string& text);  ///< throws ConfigError

/// What is asked of a camera; 0 leaves its own setting.
struct SourceSettings {
  int width = 0, height = 0;  ///< pixels
  double frame_rate_hz = 0;
  double exposure_us = 0;
  double gain_db = -1;                    ///< negative leaves the camera's own
  double black_level = -1;                ///< in the camera's own unit; negative leaves its own
  std::array<double, 3> white_balance{};  ///< red, green, blue, in the camera's own unit; 0 leaves its own
  std::string pixel_format;               ///< as "BayerRG8"; empty: the first of those that can be used
};

std::unique_ptr<FrameSource> open_source(const SourceUri& uri, const SourceSettings& settings);

}  // namespace sheen
