// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/pose_truth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "common/base/angle.h"
#include "common/base/errors.h"

namespace sheen {

SentFrames read_sent_frames(const std::filesystem::path& log) {
  std::ifstream in(log);
  if (!in) throw FileError(log.string(), "cannot be read");
  SentFrames sent;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    unsigned long long id = 0, index = 0;
    int used = 0;
    if (std::sscanf(text.c_str(), "%llu,%llu%n", &id, &index, &used) != 2 || used != static_cast<int>(text.size()))
      throw FileError(log.string(), "line " + std::to_string(line) + " is not frame_id,rig_index");
    sent.emplace(id, index);
  }
  return sent;
}

void add_pose_error(const Capture& capture, const RigRecording& recording, const SentFrames& sent, PoseErrors& errors) {
  double centre = std::numeric_limits<double>::infinity(), rotation = 0;
  const auto [begin, end] = sent.equal_range(capture.camera_frame_id);
  for (auto it = begin; it != end; ++it) {
    if (it->second >= recording.frames.size()) continue;
    const Rigid3& truth = recording.frames[it->second].camera_from_object;
    const Rigid3& pose = capture.pose.camera_from_object;
    const double distance = (camera_centre(pose) - camera_centre(truth)).norm();
    if (distance >= centre) continue;
    centre = distance;
    rotation = pose.rotation.angularDistance(truth.rotation);
  }
  if (!std::isfinite(centre)) {
    ++errors.unmatched;
    return;
  }
  errors.centre_mm.push_back(1e3 * centre);
  errors.rotation_deg.push_back(rotation / kDegree);
}

}  // namespace sheen
