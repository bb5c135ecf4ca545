// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// What a desk has of a growing model, and from where it looks at it.
struct DeskState {
  std::uint32_t scene = 0;                        ///< number of the scene that it draws; 0: none yet
  std::uint32_t changes = 0;                      ///< as many of its changes as it has
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< in metres from the mesh's origin
  bool moved = false;                             ///< it has what is seen from another eye
};

/// A growing model for desks that draw it themselves: what stays, and what has changed since a desk last asked. Bytes
/// for `reconstructor/page/live.js`; their numbers are little-endian.
class ModelStream {
 public:
  virtual ~ModelStream() = default;
  /// From now on of this snapshot, whose kind is the stream's. What is new in it is so since then.
  virtual void follow(std::shared_ptr<const ModelSnapshot> snapshot, std::chrono::steady_clock::time_point since) = 0;
  /// What stays while the mesh and its maps do.
  virtual std::string scene() = 0;
  /// What the desk lacks, the oldest change first; of much only the beginning, of which it is told that there is more.
  /// What else its eye sees comes with the last of it.
  virtual std::string changes_for(const DeskState& desk) = 0;
};

}  // namespace sheen
