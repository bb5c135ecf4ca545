// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/monitor/monitor_state.h"

namespace sheen {

/// Prometheus' text exposition format, version 0.0.4. What is not known yet has no sample.
std::string metrics_text(const MonitorState& state, CaptureState capture, MonitorState::Clock::time_point now);

}  // namespace sheen
