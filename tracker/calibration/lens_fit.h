// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "tracker/calibration/bundle.h"

namespace sheen {

/// Which numbers of a lens are estimated; the rest is 0, and fy = fx.
struct LensFit {
  const char* name;     ///< as `--lens` takes it
  const char* meaning;  ///< what is estimated
  LensModel lens;
  std::array<bool, kIntrinsics> free;  ///< in the order of `Intrinsics`

  int parameters() const { return BundleFreedom{free}.intrinsics_count(); }
};

/// From the fewest numbers to the most.
std::span<const LensFit> lens_fits();
/// Null where there is none of this name.
const LensFit* find_lens_fit(const std::string& name);

}  // namespace sheen
