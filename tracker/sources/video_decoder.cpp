// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_decoder.h"

extern "C" {
#include <libavformat/avformat.h>
}

#include <cmath>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

struct FreeFile {
  void operator()(AVFormatContext* file) const { avformat_close_input(&file); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

}  // namespace

struct VideoDecoder::Impl {
  std::string path;
  std::unique_ptr<AVFormatContext, FreeFile> file;
  std::unique_ptr<AVPacket, FreeFile> packet{av_packet_alloc()};
  AVStream* stream = nullptr;  ///< of `file`
  std::optional<PictureDecoder> pictures;

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
  if (avformat_find_stream_info(opened, nullptr) < 0) fail("cannot be read as a video");
  const AVCodec* decoder = nullptr;  // asked for, so that a stream without one is passed over
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (index < 0) fail("holds no video that can be decoded");
  stream = opened->streams[index];
  for (unsigned i = 0; i < opened->nb_streams; ++i)
    if (int(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  pictures.emplace(*stream, PictureDecoder::Kind::kFile);
  if (pictures->width() <= 0 || pictures->height() <= 0) fail("states no size");
}

/// Gives the decoder one more packet, or says that there are none left.
void VideoDecoder::Impl::feed() {
  while (av_read_frame(file.get(), packet.get()) == 0) {
    const bool ours = packet->stream_index == stream->index;
    if (ours) pictures->feed(packet.get());
    av_packet_unref(packet.get());
    if (ours) return;
  }
  pictures->feed(nullptr);
}

/// The next picture is there; false at the end.
bool VideoDecoder::Impl::decode() {
  for (;;) {
    const PictureDecoder::Step step = pictures->step();
    if (step == PictureDecoder::Step::kPicture) return true;
    if (step == PictureDecoder::Step::kEnd) return false;
    feed();
  }
}

VideoDecoder::VideoDecoder(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  try {
    impl_->open();
  } catch (const FileError&) {
    throw;
  } catch (const Error& error) {
    impl_->fail(error.what());
  }
}
VideoDecoder::~VideoDecoder() = default;

int VideoDecoder::width() const {
  return impl_->pictures->width();
}
int VideoDecoder::height() const {
  return impl_->pictures->height();
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
  return impl_->pictures->lossy();
}

std::string VideoDecoder::warning() const {
  return impl_->pictures->warning(impl_->path);
}

std::optional<VideoPicture> VideoDecoder::next() {
  Impl& self = *impl_;
  if (!self.decode()) return std::nullopt;
  const auto converted = [&self] {
    try {
      return self.pictures->picture();
    } catch (const Error& error) {
      self.fail(error.what());
    }
  };
  VideoPicture picture = converted();
  if (picture.image.width != width() || picture.image.height != height())
    self.fail(format("a picture has %d x %d pixels, the file says %d x %d", picture.image.width, picture.image.height,
                     width(), height()));
  return picture;
}

}  // namespace sheen
