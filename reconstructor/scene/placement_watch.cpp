// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/placement_watch.h"

#include <utility>

#include "common/registration/placement_check.h"

namespace sheen {

PlacementWatch::PlacementWatch(const Mesh& mesh, std::function<void(const std::string&)> warn)
    : mesh_(mesh), warn_(std::move(warn)) {}

void PlacementWatch::look(const Capture& capture) {
  if (looked_ || capture.verdict != FrameVerdict::kKeyframe || !capture.pose.usable()) return;
  first_.push_back(capture);
  if (first_.size() < kImagesToCheck) return;
  looked_ = true;
  judge_ = std::jthread([this, captures = std::exchange(first_, {})]() mutable {
    std::vector<RegistrationImage> images;
    bool on_stage = false;
    for (Capture& one : captures) {
      images.push_back(registration_image(one));
      on_stage |= !one.stage_hash.empty();
      one = {};  // what it takes is not needed longer
    }
    if (const std::string found = placement_warning(mesh_, images, on_stage); !found.empty()) warn_(found);
  });
}

}  // namespace sheen
