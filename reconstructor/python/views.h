// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// From where a picture is asked for, as a script says it: a place that is looked from and at, or a camera as it is or
/// by its matrices, or nothing.
struct AskedView {
  std::optional<Eigen::Vector3d> eye, target, up;     ///< frame of the mesh's file, metres
  std::optional<double> field_of_view;                ///< vertical, degrees
  std::optional<Eigen::Matrix3d> intrinsics;          ///< pixels; integer coordinates are pixel centres
  std::optional<Eigen::Matrix4d> camera_from_object;  ///< OpenCV axes
  std::optional<PosedCamera> camera;                  ///< with its lens
  std::optional<int> width, height;                   ///< pixels
};

/// The camera that is meant, in the frame of the mesh's file. Of nothing, the one that the model is looked at through
/// first: its own, where all images are of one camera, else one that shows all of it. 640 x 480 unless something says
/// otherwise. Throws ConfigError that names the argument.
PosedCamera camera_of(const AskedView& asked, const ModelSnapshot& model);

/// The light that is meant by its position (point, metres) or direction: without it the first that the images were
/// taken in. Throws ConfigError where the model's light is fixed.
LightState light_of(const std::optional<Eigen::Vector3d>& light, const ModelSnapshot& model);

}  // namespace sheen
