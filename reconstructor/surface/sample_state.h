// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sheen {

/// What the colour of a surface sample rests on.
enum class SampleState : std::uint8_t {
  kUnseen = 0,    ///< no image shows the sample: its colour is a guess
  kImputed = 1,   ///< fewer than half of the images round it do: how it changes with the view is mostly inferred
  kMeasured = 2,  ///< at least half of them do
};

}  // namespace sheen
