// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// Watches a capture that is coming in: its first three keyframes tell whether the mesh stands where the object is
/// (`placement_warning`). The look at them takes a moment and has a thread of its own.
class PlacementWatch {
 public:
  /// `mesh` must outlive it. `warn` is called at most once, from that thread.
  PlacementWatch(const Mesh& mesh, std::function<void(const std::string&)> warn);

  void look(const Capture& capture);

 private:
  const Mesh& mesh_;
  std::function<void(const std::string&)> warn_;
  std::vector<Capture> first_;
  bool looked_ = false;
  std::jthread judge_;
};

}  // namespace sheen
