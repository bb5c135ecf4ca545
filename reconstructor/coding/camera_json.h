// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"

namespace sheen {

// What saved models of several kinds say in JSON. Reading throws std::invalid_argument that says what is wrong.

/// A list of so many numbers, none larger than 10^9. `what` begins the message.
std::vector<double> json_numbers(const nlohmann::json& json, const std::string& what, std::size_t size);

/// A list of 19 numbers per camera: width, height, fx, fy, cx, cy, lens, five of the distortion, rotation (w, x, y, z)
/// and translation of camera_from_object.
nlohmann::ordered_json cameras_to_json(const std::vector<PosedCamera>& cameras);
std::vector<PosedCamera> cameras_from_json(const nlohmann::json& json);

}  // namespace sheen
