// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/datasets/dataset.h"
#include "common/image/image_io.h"

namespace sheen {

/// What a description leaves to its image files. Both are asked with the path as the description has it.
struct ImageFiles {
  /// The file that a `file_path` means (it may lack its extension, Blender style); empty when there is none.
  std::function<std::filesystem::path(const std::string& file_path)> find;
  /// Asked where the description gives no `w` and `h`. Throws FileError.
  std::function<ImageSize(const std::filesystem::path& image)> size;
  /// Told of a frame without its image or mask, or whose image has no size, and why; it is left out. Not given: an
  /// error.
  std::function<void(const std::string& file_path, const std::string& why)> left_out = {};
};

/// What becomes of a list (train, val, test) that names a file which no frame has.
enum class UnknownNames : std::uint8_t { kRefused, kIgnored };

/// Views of the text of a `transforms.json`: cameras (OPENCV, PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL,
/// OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, or `camera_angle_x`; for all frames or one by one), poses,
/// masks, lights (`light_position` or `light_direction`, `light_rgb`) and the lists of views. The poses stand in the
/// frame of the mesh as they are written: `applied_transform`, `applied_scale` and `orientation_override`, which tell a
/// trainer what was or is to be done to a scene, change nothing. `file` names the description in errors; reads nothing
/// itself. Throws FileError with frame and field.
std::vector<DatasetView> parse_transforms(const std::string& file, const std::string& text, const ImageFiles& images,
                                          UnknownNames unknown_names = UnknownNames::kRefused);

}  // namespace sheen
