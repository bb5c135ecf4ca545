// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_decoder.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "tracker/sources/video_colour.h"

namespace sheen {
namespace {

constexpr double kStraight = 0.01;  ///< part of a matrix's largest entry that counts as 0: half a degree

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

struct Free {
  void operator()(AVFormatContext* file) const { avformat_close_input(&file); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

}  // namespace

struct VideoDecoder::Impl {
  std::string path;
  std::unique_ptr<AVFormatContext, Free> file;
  std::unique_ptr<AVCodecContext, Free> codec;
  std::unique_ptr<AVFrame, Free> frame{av_frame_alloc()};
  std::unique_ptr<AVPacket, Free> packet{av_packet_alloc()};
  AVStream* stream = nullptr;  ///< of `file`
  std::optional<Turn> turn;
  VideoColour colour;
  int width = 0, height = 0;  ///< as stored

  [[noreturn]] void fail(const std::string& what) const { throw FileError(path, what); }
  void open();
  bool decode();
  void feed();
};

void VideoDecoder::Impl::open() {
  av_log_set_level(AV_LOG_QUIET);  // what goes wrong is told by errors
  AVFormatContext* opened = nullptr;
  if (avformat_open_input(&opened, path.c_str(), nullptr, nullptr) != 0) fail("cannot be read as a video");
  file.reset(opened);
  const AVCodec* decoder = nullptr;
  if (avformat_find_stream_info(opened, nullptr) < 0) fail("cannot be read as a video");
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (index < 0 || !decoder) fail("holds no video that can be decoded");
  stream = opened->streams[index];
  for (unsigned i = 0; i < opened->nb_streams; ++i)
    if (int(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  codec.reset(avcodec_alloc_context3(decoder));
  codec->thread_count = 0;  // as many as there are cores
  codec->pkt_timebase = stream->time_base;
  if (avcodec_parameters_to_context(codec.get(), stream->codecpar) < 0 ||
      avcodec_open2(codec.get(), decoder, nullptr) < 0)
    fail("cannot be decoded");
  width = stream->codecpar->width;
  height = stream->codecpar->height;
  if (width <= 0 || height <= 0) fail("states no size");
  turn = turn_of(*stream);
}

/// Gives the decoder one more packet, or says that there are none left.
void VideoDecoder::Impl::feed() {
  while (av_read_frame(file.get(), packet.get()) == 0) {
    const bool ours = packet->stream_index == stream->index;
    if (ours) avcodec_send_packet(codec.get(), packet.get());
    av_packet_unref(packet.get());
    if (ours) return;
  }
  avcodec_send_packet(codec.get(), nullptr);
}

/// The next picture into `frame`; false at the end.
bool VideoDecoder::Impl::decode() {
  for (;;) {
    const int answer = avcodec_receive_frame(codec.get(), frame.get());
    if (answer == 0) return true;
    if (answer == AVERROR_EOF) return false;
    feed();
  }
}

VideoDecoder::VideoDecoder(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->open();
}
VideoDecoder::~VideoDecoder() = default;

int VideoDecoder::width() const {
  return impl_->turn && impl_->turn->swaps_sides() ? impl_->height : impl_->width;
}
int VideoDecoder::height() const {
  return impl_->turn && impl_->turn->swaps_sides() ? impl_->width : impl_->height;
}

double VideoDecoder::frame_rate_hz() const {
  const double rate = av_q2d(av_guess_frame_rate(impl_->file.get(), impl_->stream, nullptr));
  return std::isfinite(rate) ? rate : 0;
}

double VideoDecoder::announced_frames() const {
  if (impl_->stream->nb_frames > 0) return static_cast<double>(impl_->stream->nb_frames);
  const std::int64_t duration = impl_->file->duration;
  return duration > 0 ? std::floor(static_cast<double>(duration) / AV_TIME_BASE * frame_rate_hz() + 0.5) : 0;
}

bool VideoDecoder::lossy() const {
  const AVCodecDescriptor* const codec = avcodec_descriptor_get(impl_->stream->codecpar->codec_id);
  return !codec || (codec->props & AV_CODEC_PROP_LOSSY);
}

std::string VideoDecoder::warning() const {
  std::string said;
  if (!impl_->turn)
    said = impl_->path +
           " says that its pictures are shown at an angle that is no multiple of 90 degrees; they are "
           "read as they are stored. ";
  const std::string colours =
      colour_warning(impl_->stream->codecpar->color_trc, impl_->stream->codecpar->color_primaries);
  if (!colours.empty()) said += impl_->path + " " + colours;
  return said;
}

std::optional<VideoDecoder::Picture> VideoDecoder::next() {
  Impl& self = *impl_;
  if (!self.decode()) return std::nullopt;
  const AVFrame& frame = *self.frame;
  if (frame.width != self.width || frame.height != self.height)
    self.fail(format("a picture has %d x %d pixels, the file says %d x %d", frame.width, frame.height, self.width,
                     self.height));
  std::vector<std::uint8_t> rgb(3 * std::size_t(self.width) * self.height);
  if (!self.colour.convert(frame, rgb.data())) self.fail("has pictures of a format that cannot be converted to RGB");
  const Turn turn = self.turn.value_or(Turn{});
  Picture picture;
  picture.image = {.format = PixelFormat::kRGB8,
                   .transfer = Transfer::kSrgb,
                   .width = width(),
                   .height = height(),
                   .stride = 3 * std::size_t(width()),
                   .bytes = turn.a == 1 && turn.d == 1 ? std::move(rgb) : turned(rgb, self.width, self.height, turn)};
  if (frame.best_effort_timestamp != AV_NOPTS_VALUE) {
    const std::int64_t start = self.stream->start_time == AV_NOPTS_VALUE ? 0 : self.stream->start_time;
    picture.time_ns = std::llround(double(frame.best_effort_timestamp - start) * av_q2d(self.stream->time_base) * 1e9);
  }
  return picture;
}

}  // namespace sheen
