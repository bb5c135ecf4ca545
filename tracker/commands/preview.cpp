// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/report_file.h"
#include "common/image/image_io.h"
#include "tracker/commands/commands.h"
#include "tracker/commands/live_source.h"
#include "tracker/preview.h"

namespace sheen {
namespace {

struct PreviewArguments {
  SourceArguments source;
  std::filesystem::path grab, json;
  double every_s = 0;
  std::uint64_t frames = 0;
};

/// Of all frames that were looked at.
struct PreviewReport {
  std::uint64_t frames = 0, incomplete = 0;
  int width = 0, height = 0;
  std::string format;
  double exposure_s = 0;
  ImageLook last;
  double best_focus = 0;
};

std::string figures_of(const PreviewReport& report) {
  std::string line =
      sheen::format("frame %llu  focus %.3f (best %.3f)  mean %.0f %%  clipped %.2f %%  dark %.1f %%  %zu tags",
                    static_cast<unsigned long long>(report.frames), report.last.focus, report.best_focus,
                    100 * report.last.mean, 100 * report.last.clipped, 100 * report.last.dark, report.last.tags);
  if (report.exposure_s > 0) line += "  " + std::to_string(std::lround(1e6 * report.exposure_s)) + " us";
  return line;
}

std::string line_of(const PreviewReport& report) {
  std::string line = figures_of(report);
  if (const std::string what = advice(report.last); !what.empty()) line += "  " + what;
  return line;
}

LiveWords words_of(const PreviewReport& report) {
  const std::string what = advice(report.last);
  return {.first = what.empty() ? "Nothing is wrong." : what,
          .well = what.empty(),
          .detail = figures_of(report),
          .focus = report.last.focus,
          .best_focus = report.best_focus};
}

std::string json_of(const PreviewReport& report) {
  return nlohmann::json{{"frames", report.frames},      {"incomplete", report.incomplete},
                        {"width", report.width},        {"height", report.height},
                        {"format", report.format},      {"exposure_us", 1e6 * report.exposure_s},
                        {"focus", report.last.focus},   {"best_focus", report.best_focus},
                        {"mean", report.last.mean},     {"clipped", report.last.clipped},
                        {"dark", report.last.dark},     {"tags", report.last.tags},
                        {"advice", advice(report.last)}}
             .dump(2) +
         "\n";
}

/// Pictures for a calibration or a survey: one every so often into a folder, beside what is there.
class GrabSeries {
 public:
  GrabSeries(std::filesystem::path folder, double every_s) : folder_(std::move(folder)), every_(every_s) {
    make_folder(folder_);
    check_writable_folder(folder_);
  }
  /// True when it took it.
  bool offer(const RawImage& image) {
    const auto now = std::chrono::steady_clock::now();
    if (count_ > 0 && now < next_) return false;
    next_ = now + std::chrono::duration_cast<std::chrono::steady_clock::duration>(every_);
    std::filesystem::path file;
    do file = folder_ / format("frame_%04zu.png", number_++);
    while (std::filesystem::exists(file));
    write_png(file, viewable(image));
    ++count_;
    return true;
  }
  std::size_t count() const { return count_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::chrono::duration<double> every_;
  std::chrono::steady_clock::time_point next_;
  std::size_t number_ = 1, count_ = 0;
};

void preview(const PreviewArguments& arguments) {
  ReportFile json(arguments.json);
  std::optional<GrabSeries> series;
  if (arguments.every_s > 0)
    series.emplace(arguments.grab, arguments.every_s);
  else if (!arguments.grab.empty())
    check_writable(arguments.grab);
  LiveSource source = arguments.source.open("preview");
  const bool terminal = ::isatty(::fileno(stdout)) == 1;
  TagDetector detector;
  PreviewReport report;
  RawImage newest;
  while (arguments.frames == 0 || report.frames < arguments.frames) {
    std::optional<Frame> frame = source.next();
    if (!frame) break;
    ++report.frames;
    report.width = frame->image.width;
    report.height = frame->image.height;
    report.format = pfnc_name(frame->image.format);
    report.exposure_s = frame->exposure.exposure_s;
    report.last = inspect(frame->image, detector);
    report.best_focus = std::max(report.best_focus, report.last.focus);
    newest = std::move(frame->image);
    source.show(newest, words_of(report));
    const bool saved = series && series->offer(newest);
    std::printf(terminal ? "\r\033[K%s%s" : "%s%s\n", line_of(report).c_str(), saved ? "  saved" : "");
    std::fflush(stdout);
  }
  report.incomplete = source.incomplete();
  if (terminal) std::printf("\n");
  if (report.frames == 0) throw Error("no whole frame came: " + source.message());
  if (series) {
    std::printf("%s: %zu frames\n", series->folder().c_str(), series->count());
  } else if (!arguments.grab.empty()) {
    write_png(arguments.grab, viewable(newest));
    std::printf("%s: the last frame\n", arguments.grab.c_str());
  }
  if (json.wanted()) json.write(json_of(report));
}

}  // namespace

void add_preview_command(Command& program) {
  Command command = program.subcommand(
      "preview", "Shows focus, exposure and tags of a camera, before anything is calibrated, and saves a frame.");
  const auto arguments = std::make_shared<PreviewArguments>();
  arguments->source.add_to(command);
  command.option("--frames", arguments->frames, "end after so many frames; 0: with Ctrl-C")
      .check(whole_number_in(0, 1'000'000'000))
      .show_default();
  const Option grab =
      command.option("--grab", arguments->grab, "PNG file of the last frame; with --every, a folder for frames");
  command.option("--every", arguments->every_s, "save a frame every so many seconds")
      .check(number_in(0.001, 86400))
      .needs(grab);
  command.option("--json", arguments->json, "report of the last frame; - for standard output");
  command.callback([arguments] { preview(*arguments); });
}

}  // namespace sheen
