// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/stream_source.h"

#include <atomic>

#include "common/base/errors.h"
#include "tracker/sources/device_feed.h"
#include "tracker/sources/network_stream.h"
#include "tracker/sources/stream_address.h"

namespace sheen {
namespace {

constexpr std::chrono::seconds kLongestPause{3};  ///< between attempts to connect again
constexpr const char* kUnknownExposure =
    " is a stream: its exposure is not known and may change by itself. Lock exposure, white balance, focus and zoom in "
    "the app where it can, and switch stabilisation off";

/// What a connection is opened with, again and again; it outlives the source while one is being opened.
struct Opening {
  const std::string address;
  StreamSize expected;  ///< once there was a connection: its size
  const std::shared_ptr<std::atomic<bool>> given_up = std::make_shared<std::atomic<bool>>(false);
  std::string warning;  ///< of the first connection

  std::unique_ptr<DeviceConnection> open() {
    auto stream = std::make_unique<NetworkStream>(address, expected, given_up);
    if (expected.width == 0) expected = stream->size();
    if (warning.empty()) warning = stream->warning();
    return stream;
  }
};

class StreamSource : public FrameSource {
 public:
  explicit StreamSource(const std::shared_ptr<Opening>& opening)
      : name_(without_password(opening->address)),
        given_up_(opening->given_up),
        feed_([opening] { return opening->open(); }, {.name = name_, .waiting = 1, .longest_pause = kLongestPause}),
        remarks_(name_ + kUnknownExposure + (opening->warning.empty() ? "" : "\n" + opening->warning)) {}
  ~StreamSource() override { *given_up_ = true; }

  std::optional<Frame> next(std::chrono::milliseconds timeout) override { return feed_.next(timeout); }
  SourceState state() const override { return feed_.state(); }
  SourceStats stats() const override { return feed_.stats(); }
  bool live() const override { return true; }
  bool compressed() const override { return true; }
  std::string remarks() const override { return remarks_; }
  std::string message() const override {
    if (state() == SourceState::kStarting) return name_ + " is connected, no frame yet";
    if (state() == SourceState::kLive) return name_ + " delivers";
    const std::string why = feed_.trouble();
    return why.empty() ? name_ + " sends nothing: is it in reach of the network, and awake?" : why;
  }

 private:
  const std::string name_;
  const std::shared_ptr<std::atomic<bool>> given_up_;
  DeviceFeed feed_;
  const std::string remarks_;
};

void refuse_what_cannot_be_set(const std::string& name, const SourceSettings& settings) {
  const auto refuse = [&](bool asked, const char* key) {
    if (asked)
      throw ConfigError(name + ": source." + key +
                        " cannot be set of a stream: set it in the app or the camera, and "
                        "leave it out");
  };
  refuse(settings.frame_rate_hz > 0, "frame_rate_hz");
  refuse(settings.exposure_us > 0, "exposure_us");
  refuse(settings.gain_db > 0, "gain_db");
  refuse(settings.black_level > 0, "black_level");
  refuse(settings.white_balance[0] > 0, "white_balance");
  refuse(!settings.pixel_format.empty() && settings.pixel_format != "RGB8", "pixel_format");
}

}  // namespace

std::unique_ptr<FrameSource> open_stream(const std::string& address, const SourceSettings& settings) {
  refuse_what_cannot_be_set(without_password(address), settings);
  return std::make_unique<StreamSource>(std::make_shared<Opening>(
      Opening{.address = address, .expected = {settings.width, settings.height}, .warning = {}}));
}

}  // namespace sheen
