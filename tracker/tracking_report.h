// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/link/wire_messages.h"
#include "tracker/pose/focal_length.h"
#include "tracker/sources/frame_source.h"

namespace sheen {

/// What became of every frame that the camera sent: camera = missed + grabbed, grabbed = overrun + judged, judged = the
/// sum over `verdicts` and over `rig_refusals`, verdicts[keyframe] = kept + unsent.
struct TrackingReport {
  std::uint64_t grabbed = 0;
  std::uint64_t overrun = 0;  ///< not looked at: the camera was faster than the tracker, or the link was full
  std::uint64_t judged = 0;
  std::map<FrameVerdict, std::uint64_t> verdicts;
  std::map<std::string, std::uint64_t> rig_refusals;  ///< by reason: its light is not known, or the rig has changed
  std::map<PoseStatus, std::uint64_t> poses;
  std::uint64_t kept = 0;    ///< keyframes handed to the link
  std::uint64_t unsent = 0;  ///< keyframes for which the link had no room
  std::uint64_t live = 0;    ///< frames sent to look at only
  /// For a person: why most of the latest frames were refused, or none comes; empty while some are kept.
  std::string trouble;
  SourceStats source;
  FocalWatch focal;            ///< of the keyframes that tags gave their pose
  std::exception_ptr failure;  ///< what ended the run before its time; empty when the source ended or was told to
  std::map<std::string, std::vector<float>> stage_ms;  ///< the latest times of each stage of the pipeline

  double median_ms(const std::string& stage) const;
  std::string failure_text() const;  ///< empty when nothing failed
};

/// A camera of a rig.
struct CameraReport {
  std::string name;  ///< empty where the rig has one camera
  TrackingReport report;
  std::uint64_t unacknowledged = 0;  ///< of its keyframes that the link took
};
using RigReport = std::vector<CameraReport>;

/// The cameras' counts added up, and their times together. Trouble and failure name the cameras that have them. Frame
/// ids mean nothing across cameras: only a rig of one has them.
TrackingReport total(const RigReport& rig);

/// The report as JSON: frames {camera, received, lost, grabbed, missed, overrun, sent, live, unsent, refused {reason:
/// n}}, poses, source, stage_ms, failure (null when there is none), focal_length {images, deviation, uncertainty,
/// spread (fractions of the calibrated one), finding} where images told it. camera = received + lost, and received =
/// refused + what a receiver has acknowledged. Of several cameras this is the total, and `cameras` has the same of each
/// by name.
std::string to_json(const RigReport& rig, const std::map<std::string, std::uint64_t>& link);

/// What the link tells of it.
TrackerFrames frames_for_link(const TrackingReport& report);

/// One line for a person, and one for each of several cameras.
std::string summary(const RigReport& rig);

}  // namespace sheen
