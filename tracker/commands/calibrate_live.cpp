// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/calibrate_live.h"

#include <unistd.h>

#include <cstdio>
#include <optional>
#include <string>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/image/image_io.h"
#include "tracker/calibration/image_set.h"
#include "tracker/calibration/view_collector.h"
#include "tracker/preview.h"

namespace sheen {
namespace {

/// One line that is written over on a terminal; elsewhere one for each view that is kept.
class GuideLine {
 public:
  static LiveWords words(const ViewCollector& collector, SeenView seen) {
    return {.first = words_of(seen, collector.next_view()),
            .well = seen == SeenView::kKept || collector.next_view().empty(),
            .detail = state_of(collector)};
  }
  void show(const ViewCollector& collector, SeenView seen) {
    const std::string line = words_of(seen, collector.next_view()) + "  (" + state_of(collector) + ")";
    if (terminal_)
      std::printf("\r\033[K%s", line.substr(0, static_cast<std::size_t>(terminal_width(stdout) - 1)).c_str());
    else if (seen == SeenView::kKept)
      std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  }
  void end() const {
    if (terminal_) std::printf("\n");
  }

 private:
  static std::string state_of(const ViewCollector& collector) {
    std::string line = format("%zu views", collector.views().size());
    if (const CalibrationStudy* study = collector.study())
      line += format(", RMS %.3f px, a pixel is uncertain by %.2f px, at worst %.1f", study->calibration.rms_px,
                     study->uncertainty.rms(), study->uncertainty.worst());
    return line;
  }
  static std::string words_of(SeenView seen, const std::string& next) {
    switch (seen) {
      case SeenView::kNoTarget:
        return "THE TARGET IS NOT SEEN";
      case SeenView::kMoving:
        return "HOLD STILL";
      case SeenView::kKept:
        return next.empty() ? "saved; nothing is missing" : "saved; next: " + next;
      case SeenView::kNothingNew:
        break;
    }
    return next.empty() ? "nothing is missing" : "next: " + next;
  }

  bool terminal_ = ::isatty(::fileno(stdout)) == 1;
};

std::filesystem::path free_name(const std::filesystem::path& folder, std::size_t& number) {
  std::filesystem::path file;
  do file = folder / format("view_%03zu.png", ++number);
  while (std::filesystem::exists(file));
  return file;
}

}  // namespace

void collect_views(LiveSource& source, const CalibrationTarget& target, const LensFit& fit,
                   const std::filesystem::path& folder, std::uint64_t frames) {
  std::optional<ViewCollector> collector;
  GuideLine line;
  std::size_t number = 0;
  for (std::uint64_t looked_at = 0; frames == 0 || looked_at < frames; ++looked_at) {
    const std::optional<Frame> frame = source.next();
    if (!frame) break;
    if (!collector) collector.emplace(target, ImageSize{frame->image.width, frame->image.height}, fit);
    // By the camera's clock: frames that waited here, or that were skipped under load, are as far apart as it took
    // them.
    const std::int64_t taken_ns = frame->times.device_ns > 0 ? frame->times.device_ns : frame->times.grabbed_ns;
    const double at_s = 1e-9 * static_cast<double>(taken_ns);
    const SeenView seen = collector->see(grey_image(frame->image), at_s, frame->exposure.exposure_s);
    if (seen == SeenView::kKept) write_png(free_name(folder, number), viewable(frame->image));
    line.show(*collector, seen);
    source.show(frame->image, GuideLine::words(*collector, seen));
    if (collector->complete()) break;
  }
  line.end();
  if (!collector || collector->views().empty())
    throw Error(
        "no view of the target was kept" +
        (collector ? std::string("; is it the one that --target names, and held still?") : ": " + source.message()));
  std::printf("%s: %zu views\n", folder.c_str(), collector->views().size());
}

}  // namespace sheen
