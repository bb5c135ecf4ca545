// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "reconstructor/shape/shape.h"

namespace sheen {

/// Finds a shape, with a progress bar, and tells on standard error what it is known from. `report`: the same in
/// figures.
FoundShape find_and_tell(const RefinementImages& images, const ShapeOptions& options, nlohmann::json& report);

}  // namespace sheen
