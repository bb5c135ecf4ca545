// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "reconstructor/coding/camera_json.h"
#include "reconstructor/numerics/reflection_drift.h"
#include "reconstructor/radiance/exposure_field.h"

namespace sheen {

// What both forms of a saved light field say in JSON. Reading throws std::invalid_argument that says what is wrong.

/// Directions run x y z per view; weights and the mean are of the log of the gain.
nlohmann::ordered_json exposure_to_json(const ExposureField& exposure);
ExposureField exposure_from_json(const nlohmann::json& json);

/// The function that all vertices share: an empty list where there is none.
nlohmann::ordered_json reflection_to_json(const ReflectionDrift* reflection);
std::shared_ptr<const ReflectionDrift> reflection_from_json(const nlohmann::json& json);

nlohmann::ordered_json kernel_to_json(const ViewKernel& kernel);  ///< scale (rad), nugget, shape
ViewKernel kernel_from_json(const nlohmann::json& json);

}  // namespace sheen
