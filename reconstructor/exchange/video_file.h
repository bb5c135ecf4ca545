// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "common/image/image.h"

namespace sheen {

enum class VideoKind {
  kMp4,   ///< H.264, which everything plays; begins to play before all of it is there
  kWebm,  ///< VP9
};
/// By a file's extension, .mp4 or .webm; empty for any other.
std::optional<VideoKind> video_kind(const std::filesystem::path& path);

/// Pictures one after the other as a video: 4:2:0, BT.709, of a quality at which coding is hardly seen.
class VideoFile {
 public:
  /// `size`: even; `path` may be called whatever. Throws FileError, also where FFmpeg's libraries came without the
  /// coder.
  VideoFile(const std::filesystem::path& path, VideoKind kind, const ImageSize& size, int frames_per_s);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// `picture`: 8-bit sRGB of that size, 3 channels. Throws FileError.
  void add(const ImageU8& picture);
  /// All pictures are there. Throws FileError.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
