// SPDX-License-Identifier: Apache-2.0
#include "tests/support/rtsp_server.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "tests/support/loopback_socket.h"

namespace sheen::testing {
namespace {

constexpr int kPacketBytes = 1400;
constexpr int kPicturesPerGroup = 12;

struct FreeMedia {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFormatContext* format) const { avformat_free_context(format); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
template <typename T>
using Media = std::unique_ptr<T, FreeMedia>;

/// Pictures as packets of RTP, each of them given to `sends`.
class RtpStream {
 public:
  using Sends = std::function<void(std::string_view)>;

  RtpStream(int width, int height, int rate_hz, Sends sends) : sends_(std::move(sends)) {
    const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_H264);
    if (!encoder) throw std::runtime_error("no encoder of H.264");
    codec_.reset(avcodec_alloc_context3(encoder));
    codec_->width = width;
    codec_->height = height;
    codec_->time_base = {1, rate_hz};
    codec_->pix_fmt = AV_PIX_FMT_YUV420P;
    codec_->gop_size = kPicturesPerGroup;
    codec_->max_b_frames = 0;
    av_opt_set(codec_->priv_data, "tune", "zerolatency", 0);
    av_opt_set(codec_->priv_data, "preset", "ultrafast", 0);
    check(avcodec_open2(codec_.get(), encoder, nullptr));
    AVFormatContext* format = nullptr;
    check(avformat_alloc_output_context2(&format, nullptr, "rtp", nullptr));
    format_.reset(format);
    AVStream* stream = avformat_new_stream(format, nullptr);
    check(avcodec_parameters_from_context(stream->codecpar, codec_.get()));
    auto* buffer = static_cast<unsigned char*>(av_malloc(kPacketBytes));
    format->pb = avio_alloc_context(buffer, kPacketBytes, 1, this, nullptr, &RtpStream::send, nullptr);
    format->pb->max_packet_size = kPacketBytes;
    check(avformat_write_header(format, nullptr));
    frame_.reset(av_frame_alloc());
    frame_->format = AV_PIX_FMT_YUV420P;
    frame_->width = width;
    frame_->height = height;
    check(av_frame_get_buffer(frame_.get(), 0));
  }
  ~RtpStream() {
    av_freep(&format_->pb->buffer);
    avio_context_free(&format_->pb);
    av_write_trailer(format_.get());  // frees what the header made; without a `pb` it sends nothing
  }
  RtpStream(const RtpStream&) = delete;
  RtpStream& operator=(const RtpStream&) = delete;

  std::string description() {
    char text[4096] = {};
    AVFormatContext* format = format_.get();
    check(av_sdp_create(&format, 1, text, sizeof text));
    return text;
  }

  void put(std::int64_t number) {
    check(av_frame_make_writable(frame_.get()));
    for (int plane = 0; plane < 3; ++plane) {
      const int rows = plane == 0 ? frame_->height : frame_->height / 2;
      std::memset(frame_->data[plane], plane == 0 ? int(40 + 10 * (number % 16)) : 128,
                  std::size_t(frame_->linesize[plane]) * rows);
    }
    frame_->pts = number;
    check(avcodec_send_frame(codec_.get(), frame_.get()));
    const Media<AVPacket> packet(av_packet_alloc());
    while (avcodec_receive_packet(codec_.get(), packet.get()) == 0) {
      av_packet_rescale_ts(packet.get(), codec_->time_base, format_->streams[0]->time_base);
      check(av_write_frame(format_.get(), packet.get()));
      av_packet_unref(packet.get());
    }
  }

 private:
  static void check(int answer) {
    if (answer < 0) throw std::runtime_error("the picture cannot be coded");
  }
  static int send(void* self, std::uint8_t* bytes, int count) {
    static_cast<RtpStream*>(self)->sends_({reinterpret_cast<const char*>(bytes), std::size_t(count)});
    return count;
  }

  const Sends sends_;
  Media<AVCodecContext> codec_;
  Media<AVFormatContext> format_;
  Media<AVFrame> frame_;
};

std::string field_of(const std::string& request, const std::string& name) {
  const std::size_t at = request.find(name + ": ");
  if (at == std::string::npos) return {};
  const std::size_t value = at + name.size() + 2;
  return request.substr(value, request.find("\r\n", value) - value);
}

}  // namespace

RtspServer::RtspServer(int width, int height, std::chrono::milliseconds between)
    : width_(width), height_(height), between_(between), listener_(listen_on_loopback(port_)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

RtspServer::~RtspServer() {
  thread_.request_stop();
  thread_.join();
  close_socket(listener_);
}

void RtspServer::run(const std::stop_token& stop) {
  serve_callers(listener_, stop, [&](int caller) {
    ++callers_;
    serve(caller, stop);
  });
}

void RtspServer::serve(int caller, const std::stop_token& stop) {
  bool there = true;
  RtpStream stream(width_, height_, int(1000 / between_.count()), [&](std::string_view packet) {
    const bool control = packet.size() > 1 && std::uint8_t(packet[1]) >= 200 && std::uint8_t(packet[1]) <= 204;
    const std::string head{'$', char(control), char(packet.size() >> 8), char(packet.size() & 255)};
    there = there && sent_all(caller, head + std::string(packet), stop);
  });
  for (bool plays = false; !plays;) {
    const std::string request = request_of(caller, stop);
    if (request.empty()) return;
    std::string body, more;
    if (request.starts_with("OPTIONS")) more = "Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN\r\n";
    if (request.starts_with("DESCRIBE")) body = stream.description();
    if (request.starts_with("SETUP") && request.find("RTP/AVP/TCP") == std::string::npos) {
      sent_all(caller, "RTSP/1.0 461 Unsupported Transport\r\nCSeq: " + field_of(request, "CSeq") + "\r\n\r\n", stop);
      continue;
    }
    if (request.starts_with("SETUP")) more = "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n";
    if (request.starts_with("PLAY")) more = "Session: 1\r\n";
    if (!body.empty())
      more = "Content-Type: application/sdp\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
    sent_all(caller, "RTSP/1.0 200 OK\r\nCSeq: " + field_of(request, "CSeq") + "\r\n" + more + "\r\n" + body, stop);
    plays = request.starts_with("PLAY");
  }
  for (std::int64_t i = 0; there && !stop.stop_requested() && !hangs_up.exchange(false); ++i) {
    stream.put(i);
    std::this_thread::sleep_for(between_);
  }
}

}  // namespace sheen::testing
