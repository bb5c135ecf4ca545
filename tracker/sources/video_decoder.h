// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tracker/sources/picture_decoder.h"

namespace sheen {

/// Reads the pictures of a video file as a player shows them (`PictureDecoder`).
class VideoDecoder {
 public:
  /// Throws FileError.
  explicit VideoDecoder(const std::string& path);
  ~VideoDecoder();

  int width() const;  ///< as it is shown
  int height() const;
  double frame_rate_hz() const;     ///< 0: not known
  double announced_frames() const;  ///< often an estimate; 0 where the file says nothing
  bool lossy() const;               ///< whether its compression loses anything
  /// What a person should know of its colours or how it is turned, a sentence; empty: nothing.
  std::string warning() const;

  /// The next; nothing at the end. What cannot be decoded is left out. Throws FileError for pictures of a format or
  /// size that cannot be used.
  std::optional<VideoPicture> next();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
