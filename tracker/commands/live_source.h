// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/base/command_line.h"
#include "tracker/commands/logging.h"
#include "tracker/live_page/live_page.h"
#include "tracker/sources/frame_source.h"

namespace sheen {

/// A camera that is looked at by a command which needs neither calibration nor stage.
class LiveSource {
 public:
  LiveSource(std::unique_ptr<FrameSource> source, const char* command, std::optional<LivePage> page);
  /// The next frame whose image is whole; nothing when the person or the source has had enough. Throws DeviceError
  /// where none comes at all, and ConfigError for one of more than 8 bits. While a source that delivered is silent, the
  /// page says so.
  std::optional<Frame> next();
  /// Shows a frame on the page, where there is one.
  void show(const RawImage& image, const LiveWords& words) {
    if (page_) page_->show(image, words);
  }
  std::uint64_t incomplete() const { return incomplete_; }
  std::string message() const { return source_->message(); }

 private:
  const Logging logging_;  ///< of a source that is gone, and back
  std::unique_ptr<FrameSource> source_;
  const char* command_;
  std::optional<LivePage> page_;
  std::uint64_t incomplete_ = 0;
  bool any_ = false;
};

/// Which one.
struct SourceArguments {
  std::filesystem::path config;
  std::string source, camera;
  double exposure_us = 0;
  std::optional<int> page;  ///< its port

  void add_to(Command& command);
  bool given() const { return !source.empty() || !config.empty(); }
  /// Throws ConfigError where none is named. `command`: the name of the one that looks.
  LiveSource open(const char* command) const;
};

}  // namespace sheen
