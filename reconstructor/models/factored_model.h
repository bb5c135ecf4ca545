// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/capture/trade.h"

namespace sheen {

/// What a model of factorizations can say of itself, beside `AppearanceModel`.
class FactoredModel {
 public:
  virtual ~FactoredModel() = default;
  /// Energy of all factors, orthogonality of a few dozen of them, evenly spread. NaN before an image.
  virtual NumericalHealth health() const = 0;
};

}  // namespace sheen
