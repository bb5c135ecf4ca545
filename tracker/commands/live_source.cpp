// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/live_source.h"

#include <chrono>
#include <iostream>
#include <utility>

#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/stop_signal.h"
#include "tracker/rig_config.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kPoll{50};
constexpr std::chrono::seconds kNothingComes{5};
constexpr std::chrono::seconds kSilent{1};

}  // namespace

LiveSource::LiveSource(std::unique_ptr<FrameSource> source, const char* command, std::optional<LivePage> page)
    : source_(std::move(source)), command_(command), page_(std::move(page)) {}

std::optional<Frame> LiveSource::next() {
  const auto begin = std::chrono::steady_clock::now();
  while (!stop_requested() && !source_->ended()) {
    std::optional<Frame> frame = source_->next(kPoll);
    if (frame && frame->given) frame->image = std::move(frame->given->image);
    if (frame && frame->complete) {
      any_ = true;
      if (bytes_per_pixel(frame->image.format) > 3)
        throw ConfigError(std::string(command_) + " looks at 8-bit images only");
      return frame;
    }
    if (frame) ++incomplete_;
    const bool silent = !frame && std::chrono::steady_clock::now() - begin > kSilent;
    if (silent && any_ && page_) page_->say({.first = source_->message()});
    if (!frame && !any_ && std::chrono::steady_clock::now() - begin > kNothingComes)
      throw DeviceError("no frame came within 5 s: " + source_->message());
  }
  return std::nullopt;
}

void SourceArguments::add_to(Command& command) {
  command.option("--source", source, "aravis:ID, video:PATH, video:ADDRESS of a stream, or dataset:DIR");
  command.option("--config", config, "rig.toml; only its [source] counts");
  command.option("--camera", camera, "which camera of a --config with several, by its name");
  command
      .option("--page", page, "port of a page on this machine that shows the picture and what to do; 0 = any free one")
      .check(range(0, 65535));
  command.option("--exposure-us", exposure_us, "exposure to set, microseconds").check(number_in(0.001, 1e8));
}

LiveSource SourceArguments::open(const char* command) const {
  RigConfig rig = config.empty() ? RigConfig{} : load_rig_config(config);
  CameraConfig& camera_config = camera_named(rig, camera);
  if (!source.empty()) camera_config.source_uri = source;
  if (exposure_us > 0) camera_config.source.exposure_us = exposure_us;
  if (!camera_config.source_uri)
    throw ConfigError("no source; give --source URI or a --config whose [source] has a uri");
  std::optional<LivePage> shown;
  if (page) shown.emplace(*page);
  if (shown) std::cerr << "sheen-tracker: the picture is at " << shown->url() << '\n';
  const EndOnStop opening("sheen-tracker: stopped before the source was open");
  std::unique_ptr<FrameSource> opened = open_source(parse_source_uri(*camera_config.source_uri), camera_config.source);
  if (const std::string remarks = opened->remarks(); !remarks.empty())
    std::cerr << "sheen-tracker: " << remarks << '\n';
  return {std::move(opened), command, std::move(shown)};
}

}  // namespace sheen
