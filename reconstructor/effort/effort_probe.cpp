// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/effort_probe.h"

#include <algorithm>
#include <cmath>

#include "common/base/log.h"
#include "reconstructor/radiance/capture_rules.h"

namespace sheen {

void EffortProbe::add(const Capture& capture, const IngestReport& report, double held_out_bytes) {
  images_.push_back({capture, held_out_bytes, exposure_product(capture) > 0 ? report.exposure_gain : 1,
                     std::pow(10, -report.predicted_psnr_db / 10)});
}

void EffortProbe::leave_out(const Capture& capture) {
  std::erase_if(images_, [&](const Image& image) {
    return image.capture.source_session == capture.source_session && image.capture.sequence == capture.sequence;
  });
}

double EffortProbe::bytes() const {
  double bytes = 0;
  for (const Image& image : images_) bytes += size_of(image.capture).bytes;
  return bytes;
}

int EffortProbe::choose(const MeasuredLevels& measured, int begun_at, int levels, double budget_ms,
                        const RayPainter& painter, const Trial& trial) const {
  const double image_ms = trial.image_ms();
  int chosen = begun_at;
  if (!measured.empty()) {
    chosen = level_within(measured, image_ms, begun_at, budget_ms);
    if (chosen != begun_at) trial.fold_at(chosen);
  } else if (image_ms > kBudgetMargin * budget_ms) {
    chosen = coarsest_that_loses_little(begun_at, levels, budget_ms, painter, trial);
  }
  if (chosen != begun_at)
    log_info("budget", "the first images take too long: a coarser model is started",
             {{"image_ms", image_ms}, {"budget_ms", budget_ms}, {"effort_level", chosen}});
  return chosen;
}

int EffortProbe::coarsest_that_loses_little(int begun_at, int levels, double budget_ms, const RayPainter& painter,
                                            const Trial& trial) const {
  std::vector<HeldOutView> views;
  for (std::size_t i = 0; i < images_.size(); i += 2)
    views.push_back(make_held_out_view(images_[i].capture, images_[i].known_gain, painter));
  const double finest = trial.error_on(views), unseen = std::max(predicted_error(), finest);
  int level = begun_at;
  while (level + 1 < levels && trial.image_ms() > kBudgetMargin * budget_ms) {
    trial.fold_at(level + 1);
    // What coarser maps and fewer terms cannot hold of the images is added to the error on images that are not seen.
    const double lost_db = 10 * std::log10(1 + std::max(0.0, trial.error_on(views) - finest) / unseen);
    log_info("budget", "a coarser model was tried on the first images",
             {{"effort_level", level + 1}, {"image_ms", trial.image_ms()}, {"lost_db", lost_db}});
    if (lost_db > kMostLoss_dB) {
      trial.fold_at(level);
      break;
    }
    ++level;
  }
  return level;
}

/// Mean over the later half of the images, each predicted from those before; 0 where none could be.
double EffortProbe::predicted_error() const {
  double sum = 0;
  int predicted = 0;
  for (std::size_t i = images_.size() / 2; i < images_.size(); ++i) {
    if (!std::isfinite(images_[i].predicted_error)) continue;
    sum += images_[i].predicted_error;
    ++predicted;
  }
  return predicted > 0 ? sum / predicted : 0;
}

}  // namespace sheen
