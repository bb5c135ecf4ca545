// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/picture_decoder.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/base/errors.h"
#include "tracker/sources/video_colour.h"

namespace sheen {
namespace {

constexpr double kStraight = 0.01;                 ///< part of a matrix's largest entry that counts as 0: half a degree
constexpr std::int64_t kMostLivePixels = 1 << 27;  ///< what a stranger may make us allocate: more than any camera has

/// How the stored picture is turned to be shown: x' = a x + c y, y' = b x + d y, each of -1, 0, 1; y points downwards.
struct Turn {
  int a = 1, b = 0, c = 0, d = 1;
  bool swaps_sides() const { return a == 0; }
};

/// Nothing where the file asks for an angle that is no multiple of 90 degrees.
std::optional<Turn> turn_of(const AVStream& stream) {
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (!data) return Turn{};
  const auto* matrix = reinterpret_cast<const std::int32_t*>(data);
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  const double most = std::max({std::abs(a), std::abs(b), std::abs(c), std::abs(d)});
  if (most == 0) return Turn{};
  const auto along = [&](double p, double q) { return std::max(std::abs(p), std::abs(q)) < kStraight * most; };
  const auto sign = [&](double value) { return std::abs(value) < kStraight * most ? 0 : value < 0 ? -1 : 1; };
  if (!along(b, c) && !along(a, d)) return std::nullopt;
  const Turn turn{sign(a), sign(b), sign(c), sign(d)};
  const bool flat = std::abs(turn.a * turn.d - turn.b * turn.c) != 1;
  return flat ? std::nullopt : std::optional(turn);
}

std::vector<std::uint8_t> turned(const std::vector<std::uint8_t>& rgb, int width, int height, const Turn& turn) {
  std::vector<std::uint8_t> out(rgb.size());
  const int out_width = turn.swaps_sides() ? height : width;
  // Where (0, 0) goes: the corner from which all others are at positive places.
  const int x0 = (turn.a < 0 ? width - 1 : 0) + (turn.c < 0 ? height - 1 : 0);
  const int y0 = (turn.b < 0 ? width - 1 : 0) + (turn.d < 0 ? height - 1 : 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int to_x = x0 + turn.a * x + turn.c * y, to_y = y0 + turn.b * x + turn.d * y;
      std::copy_n(&rgb[3 * (std::size_t(y) * width + x)], 3, &out[3 * (std::size_t(to_y) * out_width + to_x)]);
    }
  return out;
}

struct FreeDecoder {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};

}  // namespace

struct PictureDecoder::Impl {
  const AVStream& stream;
  const Kind kind;
  std::unique_ptr<AVCodecContext, FreeDecoder> codec;
  std::unique_ptr<AVFrame, FreeDecoder> frame{av_frame_alloc()};
  std::optional<Turn> turn;
  VideoColour colour;

  Impl(const AVStream& s, Kind k) : stream(s), kind(k), turn(turn_of(s)) {}
  void open();
  bool swaps_sides() const { return turn && turn->swaps_sides(); }
};

void PictureDecoder::Impl::open() {
  const AVCodec* decoder = avcodec_find_decoder(stream.codecpar->codec_id);
  if (!decoder) throw Error("holds no video that can be decoded");
  codec.reset(avcodec_alloc_context3(decoder));
  codec->thread_count = 0;  // as many as there are cores
  if (kind == Kind::kLive) {
    codec->flags |= AV_CODEC_FLAG_LOW_DELAY;
    codec->thread_type = FF_THREAD_SLICE;  // the other kind keeps a picture back for each thread
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
    if (stream.codecpar->codec_id == AV_CODEC_ID_MJPEG) codec->err_recognition |= AV_EF_EXPLODE;
    codec->max_pixels = kMostLivePixels;
  }
  codec->pkt_timebase = stream.time_base;
  if (avcodec_parameters_to_context(codec.get(), stream.codecpar) < 0 ||
      avcodec_open2(codec.get(), decoder, nullptr) < 0)
    throw Error("cannot be decoded");
}

PictureDecoder::PictureDecoder(const AVStream& stream, Kind kind) : impl_(std::make_unique<Impl>(stream, kind)) {
  impl_->open();
}
PictureDecoder::PictureDecoder(PictureDecoder&&) noexcept = default;
PictureDecoder::~PictureDecoder() = default;

int PictureDecoder::width() const {
  return impl_->swaps_sides() ? impl_->stream.codecpar->height : impl_->stream.codecpar->width;
}
int PictureDecoder::height() const {
  return impl_->swaps_sides() ? impl_->stream.codecpar->width : impl_->stream.codecpar->height;
}

bool PictureDecoder::lossy() const {
  const AVCodecDescriptor* const codec = avcodec_descriptor_get(impl_->stream.codecpar->codec_id);
  return !codec || (codec->props & AV_CODEC_PROP_LOSSY);
}

std::string PictureDecoder::warning(const std::string& name) const {
  std::string said;
  if (!impl_->turn)
    said = name +
           " says that its pictures are shown at an angle that is no multiple of 90 degrees; they are "
           "read as they are stored. ";
  const AVCodecParameters& stated = *impl_->stream.codecpar;
  const std::string colours = colour_warning(stated.color_trc, stated.color_primaries);
  if (!colours.empty()) said += name + " " + colours;
  return said;
}

PictureDecoder::Step PictureDecoder::step() {
  const int answer = avcodec_receive_frame(impl_->codec.get(), impl_->frame.get());
  if (answer == AVERROR_EOF) return Step::kEnd;
  if (answer == AVERROR(EAGAIN)) return Step::kHungry;
  if (answer < 0) return impl_->kind == Kind::kLive ? Step::kDamaged : Step::kHungry;
  const AVFrame& frame = *impl_->frame;
  const bool damaged = frame.decode_error_flags != 0 || (frame.flags & AV_FRAME_FLAG_CORRUPT);
  return damaged && impl_->kind == Kind::kLive ? Step::kDamaged : Step::kPicture;
}

bool PictureDecoder::feed(const AVPacket* packet) {
  return avcodec_send_packet(impl_->codec.get(), packet) >= 0;
}

VideoPicture PictureDecoder::picture() {
  const AVFrame& frame = *impl_->frame;
  std::vector<std::uint8_t> rgb(3 * std::size_t(frame.width) * frame.height);
  if (!impl_->colour.convert(frame, rgb.data()))
    throw Error("has pictures of a format that cannot be converted to RGB");
  const Turn turn = impl_->turn.value_or(Turn{});
  const bool as_stored = turn.a == 1 && turn.d == 1;
  const int width = turn.swaps_sides() ? frame.height : frame.width;
  const int height = turn.swaps_sides() ? frame.width : frame.height;
  VideoPicture picture;
  picture.image = {.format = PixelFormat::kRGB8,
                   .transfer = Transfer::kSrgb,
                   .width = width,
                   .height = height,
                   .stride = 3 * std::size_t(width),
                   .bytes = as_stored ? std::move(rgb) : turned(rgb, frame.width, frame.height, turn)};
  if (frame.best_effort_timestamp != AV_NOPTS_VALUE) {
    const std::int64_t start = impl_->stream.start_time == AV_NOPTS_VALUE ? 0 : impl_->stream.start_time;
    picture.time_ns = std::llround(double(frame.best_effort_timestamp - start) * av_q2d(impl_->stream.time_base) * 1e9);
  }
  return picture;
}

}  // namespace sheen
