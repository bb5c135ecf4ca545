// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/first_capture.h"

#include <utility>

#include "common/base/guarded_thread.h"
#include "reconstructor/capture/capture_storing.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kPoll{50};
constexpr const char* kMotionKey = "motion";  // metadata of a session: of the camera, then of the light
constexpr const char *kStill = "still", *kMoves = "moves";

const char* word(Motion motion) {
  return motion == Motion::kStill ? kStill : kMoves;
}

/// What a sender left open, by its first image: the camera is taken to move, the light where it has a place.
RigMotion completed(RigMotion motion, const LightState& light) {
  if (motion.camera == Motion::kUnspecified) motion.camera = Motion::kMoves;
  const bool placed = light.kind == LightKind::kDirectional || light.kind == LightKind::kPoint;
  if (motion.light == Motion::kUnspecified) motion.light = placed ? Motion::kMoves : Motion::kStill;
  return motion;
}

}  // namespace

FirstCapture::FirstCapture(Session& session, TrackerLinks& links, bool once, ArrivalObserver observer)
    : session_(session),
      links_(links),
      once_(once),
      observer_(std::move(observer)),
      thread_(guarded_thread(
          [this](const std::stop_token& stop) {
            look(stop);
            over_ = true;
          },
          [this](const std::exception_ptr& error) {
            failure_ = error;
            over_ = true;
          })) {}

std::optional<FirstCapture::Found> FirstCapture::take() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(failure_);
  return std::move(found_);
}

/// The first that can be read. One that was withdrawn will do: what it has decided stays.
std::optional<Capture> FirstCapture::in_journal() const {
  for (std::uint64_t i = 0; i < session_.size(); ++i) {
    try {
      Capture capture = session_.read(i);
      if (capture.pose.usable()) return capture;
    } catch (const DamagedCapture&) {  // told when it is its turn
    }
  }
  return std::nullopt;
}

std::optional<RigMotion> FirstCapture::noted_motion() const {
  const std::string noted = session_.metadata(kMotionKey).value_or("");
  for (const Motion camera : {Motion::kStill, Motion::kMoves})
    for (const Motion light : {Motion::kStill, Motion::kMoves})
      if (noted == std::string(word(camera)) + " " + word(light)) return RigMotion{camera, light};
  return std::nullopt;
}

/// Of a session that was begun without a note.
RigMotion FirstCapture::motion_in_journal() const {
  MotionWatch watch;
  for (std::uint64_t i = 0; i < session_.size(); ++i) {
    try {
      const Capture capture = session_.read(i);
      if (capture.pose.usable()) watch.look({capture.camera, capture.pose.camera_from_object}, capture.light);
    } catch (const DamagedCapture&) {  // told when it is its turn
    }
  }
  return watch.motion();
}

void FirstCapture::note(const RigMotion& motion, const std::stop_token& stop) {
  patiently(stop,
            [&] { session_.set_metadata(kMotionKey, std::string(word(motion.camera)) + " " + word(motion.light)); });
}

void FirstCapture::look(const std::stop_token& stop) {
  std::optional<RigMotion> motion = noted_motion();
  if (std::optional<Capture> known = in_journal()) {
    if (!motion) note(motion.emplace(motion_in_journal()), stop);
    found_ = {*std::move(known), *motion};
  }
  while (!found_ && !stop.stop_requested()) {
    std::optional<TrackerLinks::Arrival> arrival = links_.next(kPoll);
    const std::vector<LinkState> states = links_.states();
    const ReceiverStats link = joined(states);
    observer_.look(states, arrival);
    if (!arrival && link.ended && once_) return;
    if (!arrival || arrival->received.live) continue;
    Capture& capture = arrival->received.capture;
    if (capture.pose.usable()) note(motion.emplace(completed(link.motion, capture.light)), stop);
    if (!store_capture(session_, links_, *arrival, stop)) continue;
    if (capture.pose.usable()) found_ = {std::move(capture), *motion};
  }
}

}  // namespace sheen
