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
constexpr std::size_t kFittedPatches = 1000;
constexpr std::size_t kGatheredPatches = 125;  // per image: their columns that wait are projected, which costs memory

}  // namespace

void InterpolationUpkeep::after_image(std::size_t images, std::span<const std::uint32_t> due, Patches patches) {
  advance_reflection(images, patches);
  choose(due, patches);
}

void InterpolationUpkeep::rebuild(std::size_t images, Patches patches) {
  if (fitted_at_ > 0) {
    fitted_at_ = images;
    fit_reflection_now(patches);
  }
  choice_.clear();
  std::vector<std::uint32_t> all;
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (patches[p] && patches[p]->can_choose_interpolation()) all.push_back(static_cast<std::uint32_t>(p));
  choose(all, patches);
}

/// Up to `most` more levels of the sample of patches that is fitted; empty ones where no image reached a patch. True
/// when that is all.
bool InterpolationUpkeep::gather_levels(std::size_t most, Patches patches) {
  const std::size_t stride = std::max<std::size_t>(1, patches.size() / kFittedPatches);
  const std::size_t all = (patches.size() + stride - 1) / stride, first = levels_.size();
  levels_.resize(std::min(all, first + most));
  tbb::parallel_for(first, levels_.size(), [&](std::size_t i) {
    if (patches[i * stride]) levels_[i] = patches[i * stride]->levels();
  });
  return levels_.size() == all;
}

void InterpolationUpkeep::fit_reflection_now(Patches patches) {
  levels_.clear();
  gather_levels(patches.size(), patches);
  fit_.emplace(levels_);
  while (!fit_->step()) {
  }
  adopt();
}

/// Does the next part of a fit that is due or under way; while the images are few, all of it.
void InterpolationUpkeep::advance_reflection(std::size_t images, Patches patches) {
  if (!options_.drift) return;
  const bool under_way = fit_ || !levels_.empty();
  if (!under_way) {
    if (images < kFirstFit || static_cast<double>(images) < kFitGrowth * static_cast<double>(fitted_at_)) return;
    fitted_at_ = images;
    if (images <= kFewImages) return fit_reflection_now(patches);
  }
  if (fit_) {
    if (fit_->step()) adopt();
  } else if (gather_levels(kGatheredPatches, patches)) {
    fit_.emplace(levels_);
  }
}

void InterpolationUpkeep::adopt() {
  reflection_ = fit_->result();
  fit_.reset();
  levels_.clear();
}

void InterpolationUpkeep::choose(std::span<const std::uint32_t> undecided, Patches patches) {
  std::vector<InterpolationErrors> errors(undecided.size());
  tbb::parallel_for(std::size_t{0}, undecided.size(),
                    [&](std::size_t i) { errors[i] = patches[undecided[i]]->interpolation_errors(reflection_.get()); });
  std::vector<std::uint32_t> vertices;
  for (std::size_t i = 0; i < undecided.size(); ++i) {
    choice_.count(undecided[i], errors[i]);
    patches[undecided[i]]->interpolation_chosen();
    const PatchShape& shape = shapes_->patches[undecided[i]];
    vertices.insert(vertices.end(), shape.vertices.begin(), shape.vertices.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const std::uint32_t v : vertices) chosen_[v] = choice_.choose(v);
}

}  // namespace sheen
