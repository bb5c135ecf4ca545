// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// A rectangle of the picture in pixels from its top left corner.
struct Panel {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Panel&) const = default;
};

}  // namespace sheen
