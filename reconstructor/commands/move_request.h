// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/command_line.h"
#include "common/datasets/dataset.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/render/camera_moves.h"

namespace sheen {

/// From where the photographs were taken, from the side that is most in their middle: object frame. The model has a
/// camera.
LookAt first_view(const ModelSnapshot& model);

/// How a camera moves about a model; at most one of the three is given.
struct MoveRequest {
  int turntable = 0, orbit = 0;  ///< pictures
  std::string keys;              ///< file (JSON) of the views that a path goes through
  int frames = 60;               ///< of the path
  std::string size = "1280x720";

  void add_to(Command& command, const std::vector<Option>& instead_of);
  bool asked() const { return turntable > 0 || orbit > 0 || !keys.empty(); }
};

/// The views of such a move, in the frame of the mesh's file and in the model's first light; "00001" is the first.
/// Throws ConfigError where the model is seen by one camera only, FileError naming the field of the keys.
std::vector<DatasetView> views_of(const MoveRequest& request, const ModelSnapshot& model, const std::string& name);

}  // namespace sheen
