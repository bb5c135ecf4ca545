// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/live_line.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>

namespace sheen {
namespace {

constexpr std::chrono::seconds kQuiet{3};    // between two lines where there is no terminal ...
constexpr std::chrono::seconds kAlways{10};  // ... and without news
constexpr std::size_t kWidth = 100;          // of a line that is written over

}  // namespace

std::string live_line(const RigReport& rig) {
  const TrackingReport report = total(rig);
  std::string text = report.trouble;
  const auto figures = std::find(text.begin(), text.end(), '(');  // and keys of the configuration
  std::transform(text.begin(), figures, text.begin(), [](unsigned char c) { return std::toupper(c); });
  if (!text.empty()) text += "  ";
  std::string reasons;
  std::uint64_t refused = 0;
  for (const auto& [reason, count] : frames_for_link(report).refused) {
    refused += count;
    reasons += (reasons.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  }
  std::string kept;
  for (const CameraReport& camera : rig)
    if (!camera.name.empty())
      kept += (kept.empty() ? " (" : ", ") + camera.name + " " + std::to_string(camera.report.kept) + " of " +
              std::to_string(camera.report.judged);
  text += std::to_string(report.judged) + " frames, " + std::to_string(report.kept) + " kept" +
          (kept.empty() ? "" : kept + ")") + ", " + std::to_string(refused) + " refused";
  return reasons.empty() ? text : text + " (" + reasons + ")";
}

LiveLine::LiveLine(std::FILE* stream)
    : stream_(stream),
      terminal_(::isatty(::fileno(stream)) == 1),
      told_at_(std::chrono::steady_clock::now() - kQuiet) {}

LiveLine::~LiveLine() {
  if (terminal_) std::fputs("\r\033[K", stream_);
}

void LiveLine::show(const RigReport& rig) {
  const std::string trouble = total(rig).trouble;
  const bool silent = std::all_of(rig.begin(), rig.end(), [](const auto& camera) { return camera.report.judged == 0; });
  if (silent && trouble.empty()) return;
  if (terminal_) {
    std::fprintf(stream_, "\r\033[K%s", live_line(rig).substr(0, kWidth).c_str());
    std::fflush(stream_);
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  const auto since = now - told_at_;
  if (since < (trouble == told_ ? kAlways : kQuiet)) return;
  const std::uint64_t kept = total(rig).kept;
  const bool again = !told_.empty() && trouble.empty() && kept > told_kept_;
  told_ = trouble;
  told_at_ = now;
  told_kept_ = kept;
  std::fprintf(stream_, "sheen-tracker: %s%s\n", again ? "frames are kept again: " : "", live_line(rig).c_str());
  std::fflush(stream_);
}

}  // namespace sheen
