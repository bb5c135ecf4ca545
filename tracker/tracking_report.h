// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/link/wire_messages.h"
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
  std::string trouble;       ///< for a person: why most of the latest frames were refused; empty while some are kept
  SourceStats source;
  std::exception_ptr failure;  ///< what ended the run before its time; empty when the source ended or was told to
  std::map<std::string, std::vector<float>> stage_ms;  ///< the latest times of each stage of the pipeline

  double median_ms(const std::string& stage) const;
  std::string failure_text() const;  ///< empty when nothing failed
};

/// The report as JSON: frames {camera, received, lost, grabbed, missed, overrun, sent, live, unsent, refused {reason:
/// n}}, poses, source, stage_ms, failure (null when there is none). camera = received + lost, and received = refused +
/// what a receiver has acknowledged.
std::string to_json(const TrackingReport& report, const std::map<std::string, std::uint64_t>& link);

/// What the link tells of it.
TrackerFrames frames_for_link(const TrackingReport& report);

/// One line for a person.
std::string summary(const TrackingReport& report);

}  // namespace sheen
