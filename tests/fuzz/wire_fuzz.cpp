// SPDX-License-Identifier: Apache-2.0
// Whatever bytes a peer or a journal holds: a value that passes validation, or a ProtocolError.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <span>
#include <vector>

#include "common/base/errors.h"
#include "common/capture/capture_validation.h"
#include "common/image/image_codec.h"
#include "common/link/wire.h"
#include "common/link/wire_messages.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/sample_capture.h"

namespace {

using namespace sheen;
using fuzz::Input;
using Span = std::span<const std::uint8_t>;

void decode(Span envelope, Span header, Span blob) {
  const Capture capture = decode_capture(envelope, header, blob);
  if (!validation_error(capture).empty()) std::abort();
}

void arbitrary_capture(Input in) {
  const auto envelope = encode_envelope(in.byte() % 2 ? MessageType::kKeep : MessageType::kLive);
  const Span header = in.take(in.size16());
  decode(envelope, header, in.rest);
}

/// A valid message with bytes overwritten, removed and inserted where the input says.
void damaged_capture(Input in) {
  static const EncodedCapture kValid[] = {
      encode_capture(testing::sample_capture(PixelFormat::kBayerRG8, 6, 4, 1, true, 1), MessageType::kKeep,
                     Codec::kRaw),
      encode_capture(testing::sample_capture(PixelFormat::kRGB8, 6, 4, 0, false, 2), MessageType::kKeep,
                     Codec::kDeltaZstd)};
  EncodedCapture m = kValid[in.byte() % 2];
  while (in.rest.size() >= 4) {
    std::vector<std::uint8_t>& part = in.byte() % 8 ? m.header : m.blob;
    fuzz::damage_once(part, in);
  }
  decode(m.envelope, m.header, m.blob);
}

/// Behind the checksum, which a fuzzer would not get past.
void arbitrary_pixels(Input in) {
  RawImage image{
      .format = static_cast<PixelFormat>(1 + in.byte() % 7), .width = 1 + in.byte() % 32, .height = 1 + in.byte() % 32};
  image.stride = image.width * bytes_per_pixel(image.format) + in.byte() % 8;
  ImageU8 mask = in.byte() % 2 ? ImageU8(image.width, image.height, 1) : ImageU8();
  const Codec codec = in.byte() % 2 ? Codec::kRaw : Codec::kDeltaZstd;
  unpack_pixels(in.rest, codec, image, mask);
  if (image.bytes.size() != image.stride * image.height) std::abort();
}

void arbitrary_message(Input in) {
  switch (in.byte() % 8) {
    case 0:
      decode_envelope(in.rest);
      break;
    case 1:
      decode_hello(in.rest);
      break;
    case 2:
      decode_welcome(in.rest);
      break;
    case 3:
      decode_credit(in.rest);
      break;
    case 4:
      decode_ack(in.rest);
      break;
    case 5:
      decode_refuse(in.rest);
      break;
    case 6:
      decode_end(in.rest);
      break;
    default:
      decode_status(in.rest);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input in{{data, size}};
  constexpr void (*kTargets[])(Input) = {arbitrary_capture, damaged_capture, arbitrary_pixels, arbitrary_message};
  const std::size_t target = in.byte() % std::size(kTargets);
  try {
    kTargets[target](in);
  } catch (const ProtocolError&) {
  }
  return 0;
}
