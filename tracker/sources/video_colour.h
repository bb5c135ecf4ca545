// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

struct AVFrame;

namespace sheen {

/// Brings decoded pictures to 8-bit sRGB, red first, by the matrix, range, primaries and transfer function that each
/// names. Ordinary video is taken to be encoded as sRGB is; HLG, PQ, linear and logarithmic video is brought to light
/// first (ITU-R BT.2100), with its reference white (BT.2408) at full scale.
class VideoColour {
 public:
  VideoColour();
  ~VideoColour();

  /// `rgb`: width * height * 3 bytes. False where the picture's format cannot be converted.
  bool convert(const AVFrame& frame, std::uint8_t* rgb);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a person should know of colours with this transfer function and these primaries (numbers of ITU-T H.273), a
/// sentence without a subject; empty: nothing.
std::string colour_warning(int transfer, int primaries);

}  // namespace sheen
