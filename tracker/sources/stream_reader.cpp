// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/stream_reader.h"

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/base/clock.h"
#include "common/base/errors.h"
#include "tracker/sources/stream_address.h"

namespace sheen {
namespace {

constexpr std::int64_t kOpening_ns = 10'000'000'000;
constexpr std::int64_t kSilent_ns = 5'000'000'000;
constexpr const char* kAnalysed_us = "1000000";      // of the stream, before its first picture is decoded
constexpr std::size_t kMostBytes = 256 << 20;        // in one piece, whatever a stranger states
constexpr const char* kHttp = "http,https,tcp,tls";  // what an address leads to: no files of this machine
constexpr const char* kRtsp = "rtsp,rtsps,rtp,srtp,udp,tcp,tls,http,https";

struct CloseStream {
  void operator()(AVFormatContext* stream) const { avformat_close_input(&stream); }
  void operator()(AVIOContext* connection) const { avio_closep(&connection); }
};

class Settings {
 public:
  ~Settings() { av_dict_free(&all_); }
  void set(const char* key, const char* value) { av_dict_set(&all_, key, value, 0); }
  AVDictionary** get() { return &all_; }

 private:
  AVDictionary* all_ = nullptr;
};

/// What is wrong, as the end of a sentence that begins with the address; what to do.
std::string words_of_failure(int code) {
  switch (code) {
    case AVERROR(ECONNREFUSED):
      return "refuses the connection: start the stream in the app, and compare the port with the one that it shows";
    case AVERROR(EHOSTUNREACH):
    case AVERROR(ENETUNREACH):
      return "cannot be reached: are this machine and the camera in the same network?";
    case AVERROR_EXIT:
    case AVERROR(ETIMEDOUT):
      return "does not answer: is the address right, are both in the same network, and is the phone awake?";
    case AVERROR_HTTP_UNAUTHORIZED:
      return "asks for a name and a password, or does not know those (401): write http://NAME:PASSWORD@HOST...";
    case AVERROR_HTTP_FORBIDDEN:
      return "is not allowed (403): allow it in the app or the camera";
    case AVERROR_HTTP_NOT_FOUND:
      return "is not there (404): the path is another; the app shows it, /video and /videofeed are usual ones";
    case AVERROR_HTTP_BAD_REQUEST:
    case AVERROR_HTTP_OTHER_4XX:
      return "refuses the request (4xx): compare the address with the one that the app shows";
    case AVERROR_HTTP_SERVER_ERROR:
      return "has failed by itself (5xx): start the stream in the app again";
    case AVERROR_INVALIDDATA:
    case AVERROR_STREAM_NOT_FOUND:
    case AVERROR_DECODER_NOT_FOUND:
    case AVERROR_DEMUXER_NOT_FOUND:
      return "answers, but not with a stream of pictures: the address of an app's page is not that of its stream; "
             "/video and /videofeed are usual ones";
    case AVERROR_EOF:
      return "ends before its first picture: start the stream in the app again";
    default:
      break;
  }
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return std::string("cannot be opened (") + text + "): is the name of the host right?";
}

std::string kind_of_content(AVIOContext& connection) {
  std::uint8_t* type = nullptr;
  if (av_opt_get(&connection, "mime_type", AV_OPT_SEARCH_CHILDREN, &type) < 0 || !type) return {};
  std::string kind(reinterpret_cast<const char*>(type));
  av_free(type);
  return kind.substr(0, kind.find_first_of("; "));
}

}  // namespace

struct StreamReader::Impl {
  const std::string address;
  const std::shared_ptr<const std::atomic<bool>> given_up;
  std::atomic<bool> ends = false;
  std::int64_t deadline_ns = 0;                          ///< of the call that waits
  std::unique_ptr<AVIOContext, CloseStream> connection;  ///< over HTTP
  std::unique_ptr<AVFormatContext, CloseStream> source;
  AVStream* stream = nullptr;  ///< of `source`
  std::string why;

  Impl(std::string a, std::shared_ptr<const std::atomic<bool>> g) : address(std::move(a)), given_up(std::move(g)) {}
  static int is_over(void* impl) {
    const Impl& self = *static_cast<const Impl*>(impl);
    return self.ends || *self.given_up || steady_now_ns() > self.deadline_ns;
  }
  AVIOInterruptCB interrupt() { return {is_over, this}; }
  [[noreturn]] void fail(const std::string& what) const { throw DeviceError(without_password(address) + " " + what); }
  int checked(int answer) const {
    if (answer < 0) fail(words_of_failure(answer));
    return answer;
  }
  const AVInputFormat* connect();
  void open();
};

/// The connection itself first: what is wrong with it is another thing than what comes through it. The format that the
/// content says it has, null: it is to be found out.
const AVInputFormat* StreamReader::Impl::connect() {
  Settings settings;
  settings.set("protocol_whitelist", kHttp);
  settings.set("seekable", "0");
  settings.set("icy", "0");
  AVIOContext* opened = nullptr;
  const AVIOInterruptCB ends_by = interrupt();
  checked(avio_open2(&opened, address.c_str(), AVIO_FLAG_READ, &ends_by, settings.get()));
  connection.reset(opened);
  const std::string kind = kind_of_content(*opened);
  if (kind.starts_with("image/"))
    fail("delivers a single picture (" + kind +
         "), not a stream: the app shows the address of its stream; /video and /videofeed are usual ones");
  if (kind.starts_with("text/html")) fail(words_of_failure(AVERROR_INVALIDDATA));
  return kind == "multipart/x-mixed-replace" ? av_find_input_format("mpjpeg") : nullptr;
}

void StreamReader::Impl::open() {
  av_log_set_level(AV_LOG_QUIET);  // what goes wrong is told by errors
  av_max_alloc(kMostBytes);
  deadline_ns = steady_now_ns() + kOpening_ns;
  const bool http = address.starts_with("http");
  const AVInputFormat* format = http ? connect() : nullptr;
  AVFormatContext* opened = avformat_alloc_context();
  if (!opened) throw std::bad_alloc();
  opened->interrupt_callback = interrupt();
  opened->pb = connection.get();
  opened->flags |= AVFMT_FLAG_NOBUFFER;
  opened->fps_probe_size = 0;
  Settings settings;
  settings.set("protocol_whitelist", http ? kHttp : kRtsp);
  settings.set("analyzeduration", kAnalysed_us);
  if (!http) settings.set("rtsp_flags", "prefer_tcp");  // over UDP a lost packet is a damaged picture
  if (!http) settings.set("allowed_media_types", "video");
  const int answer = avformat_open_input(&opened, address.c_str(), format, settings.get());  // frees it where it fails
  checked(http && answer == AVERROR(EIO) ? AVERROR_INVALIDDATA : answer);  // what answered is no video
  source.reset(opened);
  checked(avformat_find_stream_info(opened, nullptr));
  if (http && opened->duration > 0)
    fail("is a recording, not a live stream: download it, and give its path as --source video:PATH");
  const AVCodec* decoder = nullptr;
  const int index = checked(av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0));
  stream = opened->streams[index];
  for (unsigned i = 0; i < opened->nb_streams; ++i)
    if (int(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
}

StreamReader::StreamReader(const std::string& address, std::shared_ptr<const std::atomic<bool>> given_up)
    : impl_(std::make_unique<Impl>(address, std::move(given_up))) {
  if (const std::string wrong = address_error(address); !wrong.empty()) impl_->fail(wrong);
  impl_->open();
}
StreamReader::~StreamReader() = default;

const AVStream& StreamReader::stream() const {
  return *impl_->stream;
}

PacketPtr StreamReader::read() {
  Impl& self = *impl_;
  self.deadline_ns = steady_now_ns() + kSilent_ns;
  for (;;) {
    PacketPtr packet = make_packet();
    const int answer = av_read_frame(self.source.get(), packet.get());
    if (answer >= 0 && packet->stream_index == self.stream->index) return packet;
    if (answer >= 0) continue;
    const bool silent = answer == AVERROR_EXIT || answer == AVERROR(ETIMEDOUT);
    self.why = silent                                            ? "has sent nothing for 5 s"
               : answer == AVERROR_EOF || answer == AVERROR(EIO) ? "has ended the connection"
                                                                 : words_of_failure(answer);
    return nullptr;
  }
}

std::string StreamReader::why_ended() const {
  return impl_->why;
}

void StreamReader::give_up() {
  impl_->ends = true;
}

}  // namespace sheen
