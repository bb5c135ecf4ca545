// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/video_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <string>
#include <utility>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

struct Free {
  void operator()(AVFormatContext* file) const {
    avio_closep(&file->pb);
    avformat_free_context(file);
  }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

struct Coding {
  const char *container, *coder;
  /// Of coder and container; each takes those that it knows.
  std::vector<std::pair<const char*, const char*>> options;
};
Coding coding_of(VideoKind kind) {
  if (kind == VideoKind::kMp4)
    return {"mp4", "libx264", {{"crf", "17"}, {"preset", "medium"}, {"movflags", "+faststart"}}};
  return {"webm", "libvpx-vp9", {{"crf", "24"}, {"b", "0"}, {"row-mt", "1"}, {"cpu-used", "2"}}};
}

}  // namespace

std::optional<VideoKind> video_kind(const std::filesystem::path& path) {
  if (path.extension() == ".mp4") return VideoKind::kMp4;
  if (path.extension() == ".webm") return VideoKind::kWebm;
  return std::nullopt;
}

struct VideoFile::Impl {
  std::string path;
  std::unique_ptr<AVFormatContext, Free> file;
  std::unique_ptr<AVCodecContext, Free> codec;
  std::unique_ptr<AVFrame, Free> frame{av_frame_alloc()};
  std::unique_ptr<AVPacket, Free> packet{av_packet_alloc()};
  std::unique_ptr<SwsContext, Free> colours;
  AVStream* stream = nullptr;  ///< of `file`

  [[noreturn]] void fail(const std::string& what) const { throw FileError(path, what); }
  void check(int answer, const char* what) const {
    if (answer >= 0) return;
    char reason[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(answer, reason, sizeof(reason));
    fail(std::string(what) + ": " + reason);
  }
  void open(const Coding& coding, const ImageSize& size, int frames_per_s);
  void set_options(const Coding& coding);
  void code(const AVFrame* picture);
};

void VideoFile::Impl::set_options(const Coding& coding) {
  for (const auto& [name, value] : coding.options) {
    av_opt_set(codec.get(), name, value, AV_OPT_SEARCH_CHILDREN);
    av_opt_set(file.get(), name, value, AV_OPT_SEARCH_CHILDREN);
  }
}

void VideoFile::Impl::open(const Coding& coding, const ImageSize& size, int frames_per_s) {
  av_log_set_level(AV_LOG_QUIET);  // what goes wrong is told by errors
  const AVCodec* coder = avcodec_find_encoder_by_name(coding.coder);
  if (!coder) fail(std::string("cannot be written: this system's libavcodec has no ") + coding.coder);
  AVFormatContext* opened = nullptr;
  check(avformat_alloc_output_context2(&opened, nullptr, coding.container, path.c_str()), "cannot be written");
  file.reset(opened);
  codec.reset(avcodec_alloc_context3(coder));
  codec->width = size.width;
  codec->height = size.height;
  codec->pix_fmt = AV_PIX_FMT_YUV420P;
  codec->color_range = AVCOL_RANGE_MPEG;
  codec->colorspace = AVCOL_SPC_BT709;
  codec->color_primaries = AVCOL_PRI_BT709;
  codec->color_trc = AVCOL_TRC_BT709;
  codec->chroma_sample_location = AVCHROMA_LOC_LEFT;
  codec->time_base = {1, frames_per_s};
  codec->framerate = {frames_per_s, 1};
  codec->gop_size = frames_per_s;  // so that any moment of it is shown soon
  codec->thread_count = 0;         // as many as there are cores
  if (file->oformat->flags & AVFMT_GLOBALHEADER) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  set_options(coding);
  check(avcodec_open2(codec.get(), coder, nullptr), "cannot be coded");
  stream = avformat_new_stream(opened, nullptr);
  if (!stream) fail("cannot be written: out of memory");
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  check(avcodec_parameters_from_context(stream->codecpar, codec.get()), "cannot be coded");
  check(avio_open(&opened->pb, path.c_str(), AVIO_FLAG_WRITE), "cannot be written");
  check(avformat_write_header(opened, nullptr), "cannot be written");

  frame->format = codec->pix_fmt;
  frame->width = size.width;
  frame->height = size.height;
  frame->pts = 0;
  check(av_frame_get_buffer(frame.get(), 0), "cannot be coded");
  colours.reset(sws_getContext(size.width, size.height, AV_PIX_FMT_RGB24, size.width, size.height, codec->pix_fmt,
                               SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP, nullptr, nullptr, nullptr));
  if (!colours) fail("cannot be coded: this size is not possible");
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  constexpr int kFullRange = 1, kLimitedRange = 0, kAsItIs = 1 << 16;
  sws_setColorspaceDetails(colours.get(), bt709, kFullRange, bt709, kLimitedRange, 0, kAsItIs, kAsItIs);
}

/// Null: what is still on its way.
void VideoFile::Impl::code(const AVFrame* picture) {
  check(avcodec_send_frame(codec.get(), picture), "cannot be coded");
  for (;;) {
    const int answer = avcodec_receive_packet(codec.get(), packet.get());
    if (answer == AVERROR(EAGAIN) || answer == AVERROR_EOF) return;
    check(answer, "cannot be coded");
    packet->stream_index = stream->index;
    packet->duration = 1;
    av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
    check(av_interleaved_write_frame(file.get(), packet.get()), "cannot be written");
  }
}

VideoFile::VideoFile(const std::filesystem::path& path, VideoKind kind, const ImageSize& size, int frames_per_s)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path.string();
  impl_->open(coding_of(kind), size, frames_per_s);
}

VideoFile::~VideoFile() = default;

void VideoFile::add(const ImageU8& picture) {
  AVFrame& frame = *impl_->frame;
  if (picture.width() != frame.width || picture.height() != frame.height || picture.channels() != 3)
    impl_->fail("all pictures of a video have one size");
  impl_->check(av_frame_make_writable(&frame), "cannot be coded");
  const std::uint8_t* rows[] = {picture.data()};
  const int strides[] = {3 * picture.width()};
  sws_scale(impl_->colours.get(), rows, strides, 0, picture.height(), frame.data, frame.linesize);
  impl_->code(&frame);
  ++frame.pts;
}

void VideoFile::finish() {
  impl_->code(nullptr);
  impl_->check(av_write_trailer(impl_->file.get()), "cannot be written");
  impl_->check(avio_closep(&impl_->file->pb), "cannot be written");
}

}  // namespace sheen
