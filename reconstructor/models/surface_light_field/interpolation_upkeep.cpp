// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/interpolation_upkeep.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheen {
namespace {

// The reflection is fitted again as the images get more: what one more can change gets less and less.
constexpr std::size_t kFirstFit = 6;
constexpr double kFitGrowth = 1.4;
constexpr std::size_t kFewImages = 16;  // up to here a fit is cheap enough for one image
constexpr std::size_t kFittedRings = 1000;
constexpr std::size_t kGatheredRings = 125;  // an image: their columns that wait are projected, which costs memory

}  // namespace

void InterpolationUpkeep::after_image(std::size_t images, std::span<const std::uint32_t> due, Frames frames,
                                      Rings& rings) {
  advance_reflection(images, frames, rings);
  choose(due, frames, rings);
}

void InterpolationUpkeep::rebuild(std::size_t images, Frames frames, Rings& rings) {
  if (fitted_at_ > 0) {
    fitted_at_ = images;
    fit_reflection_now(frames, rings);
  }
  choice_.clear();
  std::vector<std::uint32_t> all;
  for (std::size_t v = 0; v < rings.size(); ++v)
    if (rings[v] && rings[v]->can_choose_interpolation()) all.push_back(static_cast<std::uint32_t>(v));
  choose(all, frames, rings);
}

/// Up to `most` more levels of the sample of rings that is fitted; empty ones where no image reached a ring. True when
/// that is all.
bool InterpolationUpkeep::gather_levels(std::size_t most, Frames frames, const Rings& rings) {
  const std::size_t stride = std::max<std::size_t>(1, rings.size() / kFittedRings);
  const std::size_t all = (rings.size() + stride - 1) / stride, first = levels_.size();
  levels_.resize(std::min(all, first + most));
  tbb::parallel_for(first, levels_.size(), [&](std::size_t i) {
    const std::size_t v = i * stride;
    if (rings[v]) levels_[i] = rings[v]->levels(frames[v].row(2));
  });
  return levels_.size() == all;
}

void InterpolationUpkeep::fit_reflection_now(Frames frames, Rings& rings) {
  levels_.clear();
  gather_levels(rings.size(), frames, rings);
  fit_.emplace(levels_);
  while (!fit_->step()) {
  }
  adopt(rings);
}

/// Does the next part of a fit that is due or under way; while the images are few, all of it.
void InterpolationUpkeep::advance_reflection(std::size_t images, Frames frames, Rings& rings) {
  if (!options_.drift) return;
  const bool under_way = fit_ || !levels_.empty();
  if (!under_way) {
    if (images < kFirstFit || static_cast<double>(images) < kFitGrowth * static_cast<double>(fitted_at_)) return;
    fitted_at_ = images;
    if (images <= kFewImages) return fit_reflection_now(frames, rings);
  }
  if (fit_) {
    if (fit_->step()) adopt(rings);
  } else if (gather_levels(kGatheredRings, frames, rings)) {
    fit_.emplace(levels_);
  }
}

void InterpolationUpkeep::adopt(Rings& rings) {
  reflection_ = fit_->result();
  fit_.reset();
  levels_.clear();
  for (const auto& ring : rings)
    if (ring) ring->set_reflection(reflection_);
}

void InterpolationUpkeep::choose(std::span<const std::uint32_t> undecided, Frames frames, Rings& rings) {
  std::vector<InterpolationErrors> errors(undecided.size());
  tbb::parallel_for(std::size_t{0}, undecided.size(), [&](std::size_t i) {
    const std::uint32_t v = undecided[i];
    errors[i] = rings[v]->interpolation_errors(frames[v].row(2));
  });
  for (std::size_t i = 0; i < undecided.size(); ++i) choice_.count(undecided[i], errors[i]);
  for (const std::uint32_t v : undecided) rings[v]->set_interpolation(choice_.choose(v));
}

}  // namespace sheen
