// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Prints which intervals between the model's lights are too wide for errors of this many grey levels, and where the
/// next light is worth most; the same for a report.
nlohmann::json light_report(const ModelSnapshot& snapshot, double tolerance);

}  // namespace sheen
