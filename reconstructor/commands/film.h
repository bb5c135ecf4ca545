// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/base/command_line.h"
#include "common/image/image.h"

namespace sheen {

/// How pictures become a video, where they go into one.
struct FilmRequest {
  int frames_per_s = 30;
  std::string background = "#1c1f22";  ///< as the window has it

  void add_to(Command& command);
};

/// Whether a path is that of a video: .mp4 or .webm.
bool is_film(const std::filesystem::path& out);

/// Straight 8-bit sRGB with alpha over a colour (#rrggbb): 3 channels, mixed as light. Without alpha as it is. Throws
/// ConfigError where it is no colour.
ImageU8 over_background(const ImageU8& picture, const std::string& background);

/// Writes `count` pictures as a video: 3 or 4 channels, of one even size. What was written, for the report. Until it is
/// whole an older file stays. Throws ConfigError where the size is odd, FileError, Error where it is stopped.
nlohmann::json write_film(const std::filesystem::path& out, const FilmRequest& request, std::size_t count,
                          const std::function<ImageU8(std::size_t)>& picture);

}  // namespace sheen
