// SPDX-License-Identifier: Apache-2.0
#include "common/base/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kRedraw{100};
constexpr std::chrono::seconds kNextLine{10};  ///< where there is no terminal
constexpr int kLineWidth = 100;
constexpr int kNarrowestBar = 8;

std::mutex terminal_mutex;
std::FILE* bar_on = nullptr;  ///< the terminal whose line a bar has; guarded by `terminal_mutex`

void clear_line(std::FILE* terminal) {
  std::fputs("\r\x1b[K", terminal);
  std::fflush(terminal);
}

std::string duration(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s / 60 % 60) + " min";
}

std::string rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), value < 9.95 ? "%.1f" : "%.0f", value);
  return text.data();
}

}  // namespace

int terminal_width(std::FILE* stream) {
  winsize size{};
  return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

Progress::Progress(std::string label, std::uint64_t total, std::FILE* stream)
    : label_(std::move(label)),
      total_(total),
      stream_(stream),
      terminal_(isatty(fileno(stream)) == 1),
      started_(std::chrono::steady_clock::now()),
      shown_(terminal_ ? started_ - kRedraw : started_) {}

Progress::~Progress() {
  if (!terminal_) return;
  const std::lock_guard lock(terminal_mutex);
  clear_line(stream_);
  bar_on = nullptr;
}

void Progress::update(std::uint64_t done) {
  const auto now = std::chrono::steady_clock::now();
  if (terminal_ ? now - shown_ < kRedraw : now - shown_ < kNextLine) return;
  shown_ = now;
  const std::lock_guard lock(terminal_mutex);
  const double elapsed_s = std::chrono::duration<double>(now - started_).count();
  if (!terminal_) {
    std::fprintf(stream_, "%s\n", progress_line(label_, done, total_, elapsed_s, kLineWidth).c_str());
    std::fflush(stream_);
    return;
  }
  bar_on = stream_;
  // One column stays free: a full line makes some terminals wrap.
  std::fprintf(stream_, "\r%s\x1b[K",
               progress_line(label_, done, total_, elapsed_s, terminal_width(stream_) - 1).c_str());
  std::fflush(stream_);
}

ProgressPause::ProgressPause() : lock_(terminal_mutex) {
  if (bar_on) clear_line(bar_on);
  bar_on = nullptr;
}

std::string progress_line(const std::string& label, std::uint64_t done, std::uint64_t total, double elapsed_s,
                          int width) {
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0;
  if (total == 0 && done == 0) return (label + " ...").substr(0, static_cast<std::size_t>(std::max(width, 0)));
  std::string figures = std::to_string(done);
  if (total > 0) {
    const double fraction = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    figures += "/" + std::to_string(total) + "  " + std::to_string(static_cast<int>(100 * fraction)) + " %";
  }
  if (rate > 0) figures += "  " + rounded(rate) + "/s";
  if (rate > 0 && total > done) figures += "  " + duration(static_cast<double>(total - done) / rate) + " left";

  std::string line = label + " ";
  const int room = width - static_cast<int>(line.size() + figures.size()) - 3;
  if (total > 0 && room >= kNarrowestBar) {
    const int bar = std::min(room, 40);
    const auto filled =
        static_cast<int>(std::min<std::uint64_t>(done, total) * static_cast<std::uint64_t>(bar) / total);
    line += "[" + std::string(static_cast<std::size_t>(filled), '#') +
            std::string(static_cast<std::size_t>(bar - filled), '.') + "] ";
  }
  line += figures;
  return line.substr(0, static_cast<std::size_t>(std::max(width, 0)));
}

StepsDone progress_bar(std::string label) {
  return [label = std::move(label), bar = std::shared_ptr<Progress>()](std::size_t done, std::size_t steps) mutable {
    if (!bar) bar = std::make_shared<Progress>(label, steps);
    bar->update(done);
  };
}

}  // namespace sheen
