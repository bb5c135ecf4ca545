// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/sweep_minimum.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr double kEnergyFloor = 0.01;  // of an energy that runs from 0 to 1: no match is more certain than this

}  // namespace

std::optional<SweepMinimum> sweep_minimum(const NormalSweep::Energy& energy, int images, double guide, double pull) {
  if (images < 2) return {};
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSweepPlaces; ++k) {
    const double pulled = energy[k] + pull * std::pow(k - kSweepReach - guide, 2);
    if (pulled >= least) continue;
    least = pulled;
    best = k;
  }
  if (best == 0 || best == kSweepPlaces - 1) return {};
  const double below = energy[best - 1], here = energy[best], above = energy[best + 1];
  const double curvature = below - 2 * here + above;
  if (!(curvature > 0)) return {};
  const double between = std::clamp(0.5 * (below - above) / curvature, -1.0, 1.0);
  // n images of kPatchPoints values each, whose variance about their mean is here * n / (n - 1) / kPatchPoints; half
  // the second derivative of n * energy, over it.
  const double information = 0.5 * (images - 1) * kPatchPoints * curvature / (here + kEnergyFloor);
  return SweepMinimum{best - kSweepReach + between, information};
}

}  // namespace sheen
