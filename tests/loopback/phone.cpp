// SPDX-License-Identifier: Apache-2.0
#include "tests/loopback/phone.h"

#include <utility>

#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"

namespace sheen::testing {
namespace {

constexpr int kQuality = 90;

RawImage image_of(const RigRecording& recording, const RigFrame& frame) {
  const std::string bytes = read_file(frame.raw_file);
  return {.format = recording.format,
          .transfer = Transfer::kLinear,
          .width = recording.camera.width,
          .height = recording.camera.height,
          .stride = bytes_per_pixel(recording.format) * std::size_t(recording.camera.width),
          .bytes = {bytes.begin(), bytes.end()}};
}

}  // namespace

std::vector<std::string> jpegs_of(const RigRecording& recording, const GainOfFrame& gain) {
  std::vector<std::string> jpegs;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    ImageF light = to_linear_rgb(image_of(recording, recording.frames[i]), recording.exposure.black_level,
                                 recording.exposure.white_balance.data());
    const Gains factors = gain ? gain(i) : Gains{1, 1, 1};
    for (int y = 0; y < light.height(); ++y)
      for (int x = 0; x < light.width(); ++x)
        for (std::size_t c = 0; c < 3; ++c) light.pixel(x, y)[c] *= static_cast<float>(factors[c]);
    const std::vector<std::uint8_t> bytes = encode_jpeg(to_srgb8(light), kQuality);
    jpegs.emplace_back(bytes.begin(), bytes.end());
  }
  return jpegs;
}

MjpegServer::Picture again_and_again(std::vector<std::string> pictures, std::uint64_t times_each) {
  return [pictures = std::move(pictures), times_each](std::uint64_t i) {
    return pictures[i / times_each % pictures.size()];
  };
}

}  // namespace sheen::testing
