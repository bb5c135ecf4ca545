// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/datasets/dataset.h"

namespace sheen {

/// Cameras of the text of a `camera_path.json` as nerfstudio's viewer writes it: `camera_path` with `camera_to_world`
/// (16 numbers, row by row, OpenGL axes) and `fov` (degrees from top to bottom) of each, `render_width` and
/// `render_height` of all. They have no images; their names are their numbers, "00000" first. Empty: the text has no
/// `camera_path`. Throws FileError with camera and field, also for other cameras than perspective ones.
std::optional<std::vector<DatasetView>> parse_camera_path(const std::string& file, const std::string& text);

}  // namespace sheen
