// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reconstructor/capture/saved_model.h"
#include "reconstructor/python/views.h"
#include "reconstructor/render/model_painter.h"

namespace sheen {

/// A saved model in a script's hands: everything in the frame of its mesh's file. Thread-safe.
class OpenModel {
 public:
  /// Throws FileError.
  explicit OpenModel(std::filesystem::path path) : path_(std::move(path)), saved_(open_model(path_)) {}

  const std::filesystem::path& path() const { return path_; }
  const SavedModel& saved() const { return saved_; }
  const ModelSnapshot& snapshot() const { return *saved_.snapshot; }
  /// That it was made of.
  std::size_t images() const;

  /// As `render` draws it. Throws ConfigError.
  SmoothView paint(const AskedView& view, const std::optional<Eigen::Vector3d>& light) const;
  /// Layers by their names (`PictureLayers`), as `render --layers` writes them. Throws ConfigError.
  std::vector<std::pair<std::string, ImageF>> layers(const std::vector<std::string>& names, const AskedView& view,
                                                     const std::optional<Eigen::Vector3d>& light) const;

 private:
  const ModelPainter& painter() const;

  std::filesystem::path path_;
  SavedModel saved_;
  mutable std::once_flag first_picture_;
  mutable std::unique_ptr<const ModelPainter> painter_;  ///< made for the first picture
};

}  // namespace sheen
