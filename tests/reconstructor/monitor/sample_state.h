// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/monitor/monitor_state.h"

namespace sheen {

/// A capture in full swing; every figure differs from every other.
MonitorState sample_monitor_state();

}  // namespace sheen
