// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/capture.h"

namespace sheen {

/// One posed image of a dataset, not yet read.
struct DatasetView {
  std::string name;  ///< `file_path` as the dataset writes it
  std::filesystem::path image_path;
  std::optional<std::filesystem::path> mask_path;
  Camera camera;
  Rigid3 camera_from_object;
  Purpose purpose = Purpose::kUnspecified;
  std::optional<double> exposure_s;  ///< from EXIF or the file, when it is there
};

/// Posed image set: a folder with `transforms.json` (nerfstudio / instant-ngp keys, OpenGL axes) or a COLMAP model
/// (text or binary). Views stand in the order of the file.
struct Dataset {
  std::filesystem::path root;
  std::vector<DatasetView> views;
  std::string hash;  ///< of the description file: names the source session, so that a repeated run is recognised
};

/// Throws FileError naming file, frame and field. Images are checked for existence, not read.
Dataset load_dataset(const std::filesystem::path& folder);

/// Reads a view's image (JPEG, PNG: 8-bit sRGB; EXR: linear float) and mask. `sequence` counts from 1. An image whose
/// size differs from its camera's is an error that names both.
Capture read_capture(const Dataset& dataset, std::size_t view);

/// `transforms.json` for these views (OpenGL axes, principal point shifted by 0.5), masks where all views have one,
/// train / val / test lists where any view is held out.
void write_transforms(const std::filesystem::path& file, const std::vector<DatasetView>& views);

}  // namespace sheen
