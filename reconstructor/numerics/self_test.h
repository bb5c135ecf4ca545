// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sheen {

/// An extreme that a factor was put to: what was measured, and what it may be at most.
struct NumericsCheck {
  std::string name;
  double value = 0, bound = 0;
  bool holds() const { return value <= bound; }  // and so not where it is no number
};

/// Puts `shipped_factor` to the extremes of docs/numerics.md, on this machine and as this program was compiled: a few
/// seconds. Inputs are made here, encoded colours as of a camera; the truth is known by formula or from a batch SVD in
/// double precision.
std::vector<NumericsCheck> numerics_self_test();

}  // namespace sheen
