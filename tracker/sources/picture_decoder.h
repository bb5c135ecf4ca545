// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/image/raw_image.h"

struct AVPacket;
struct AVStream;

namespace sheen {

/// A picture of a video: sRGB, 8 bits.
struct VideoPicture {
  RawImage image;
  std::optional<std::int64_t> time_ns;  ///< by the video's own clock; nothing: it does not say
};

/// Makes pictures of the packets of a video, as a player shows them: turned as the video says, in the colours that it
/// names (`VideoColour`).
class PictureDecoder {
 public:
  enum class Kind {
    kFile,  ///< decoded by all cores
    kLive,  ///< no picture waits in the decoder for later ones; a damaged one is told as such
  };
  /// `stream` must outlive this. Throws Error, a sentence without its subject.
  PictureDecoder(const AVStream& stream, Kind kind);
  PictureDecoder(PictureDecoder&&) noexcept;
  ~PictureDecoder();

  int width() const;  ///< as the video states it, and as it is shown; 0: it does not say
  int height() const;
  bool lossy() const;  ///< whether its compression loses anything
  /// What a person should know of the colours of `name` or how it is turned, sentences; empty: nothing.
  std::string warning(const std::string& name) const;

  enum class Step {
    kPicture,  ///< one is there for `picture`
    kDamaged,  ///< one of which a part could not be decoded
    kHungry,   ///< needs another packet
    kEnd,      ///< there are no more
  };
  Step step();
  /// The next packet; null: there are none left. False where it could not be decoded.
  bool feed(const AVPacket* packet);
  /// Of the last `step`. Throws Error, a sentence without its subject, for a format that cannot be converted.
  VideoPicture picture();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
