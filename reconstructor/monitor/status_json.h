// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "reconstructor/monitor/monitor_state.h"

namespace sheen {

/// Numbers of the pictures that are there: another number, another picture; 0 = none.
struct PictureVersions {
  std::uint64_t preview = 0, shape = 0, camera = 0;  ///< 0: there is none
  bool model_page = false;                           ///< there is a page that draws the model itself
};

/// What the page and `sheen-reconstructor monitor` read. SI units; a figure that is not known is null. A long held-out
/// curve is thinned to some hundred points, its last one always among them. `may_steer`: whoever reads it.
std::string status_json(const MonitorState& state, CaptureState capture, double published_age_s, double frame_age_s,
                        const PictureVersions& pictures, bool may_steer = false);

}  // namespace sheen
