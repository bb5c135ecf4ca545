// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>
#include <optional>
#include <thread>

#include "common/capture/rig_motion.h"
#include "common/session/session.h"
#include "reconstructor/capture/tracker_links.h"

namespace sheen {

/// The first image of a session that has a pose, and what moves between its images: what decides which model there is
/// to be, and of which surface. The image is read from the journal or, where there is none yet, received, journaled and
/// acknowledged; what moves is as the sender announced it, and noted in the session before. A later start finds both.
/// On a thread of its own.
class FirstCapture {
 public:
  struct Found {
    Capture capture;
    RigMotion motion;
  };

  /// Both must outlive it; nothing else uses them until it is over. `once`: no other source follows one that ends.
  FirstCapture(Session& session, TrackerLinks& links, bool once, ArrivalObserver observer);

  /// It is there, or none will come.
  bool over() const { return over_; }
  /// Ends the wait. Nothing where there was none. Throws what went wrong.
  std::optional<Found> take();

 private:
  void look(const std::stop_token& stop);
  std::optional<Capture> in_journal() const;
  std::optional<RigMotion> noted_motion() const;
  RigMotion motion_in_journal() const;
  void note(const RigMotion& motion, const std::stop_token& stop);

  Session& session_;
  TrackerLinks& links_;
  const bool once_;
  ArrivalObserver observer_;
  std::optional<Found> found_;
  std::exception_ptr failure_;
  std::atomic<bool> over_{false};
  std::jthread thread_;
};

}  // namespace sheen
