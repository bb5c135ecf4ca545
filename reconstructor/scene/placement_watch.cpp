// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/placement_watch.h"

#include <utility>

#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "common/registration/placement_check.h"

namespace sheen {

PlacementWatch::PlacementWatch(const Mesh& mesh, std::function<void(const std::string&)> warn)
    : mesh_(mesh), warn_(std::move(warn)) {}

void PlacementWatch::look(const Capture& capture) {
  if (looked_ || capture.verdict != FrameVerdict::kKeyframe || !capture.pose.usable()) return;
  first_.push_back(capture);
  if (first_.size() < kImagesToCheck) return;
  looked_ = true;
  auto judge = [this, captures = std::exchange(first_, {})]() mutable {
    std::vector<RegistrationImage> images;
    bool on_stage = false;
    for (Capture& one : captures) {
      images.push_back(registration_image(one));
      on_stage |= !one.stage_hash.empty();
      one = {};  // what it takes is not needed longer
    }
    if (const std::string found =
            placement_warning(mesh_, images, {.on_stage = on_stage, .applied = {}, .more = {}}).text;
        !found.empty())
      warn_(found);
  };
  judge_ = guarded_thread(std::move(judge), [](const std::exception_ptr& error) {
    log_error("mesh", "whether it stands where the object is was not found out: " + words_of(error));
  });
}

}  // namespace sheen
