// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/capture/capture.h"
#include "common/capture/trade.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

enum class TrackerLink {
  kNone,       ///< nobody is expected: a saved model is looked at
  kWaiting,    ///< listening; no tracker has come yet
  kConnected,  ///< frames or heartbeats arrive
  kStale,      ///< the tracker fell silent: what is on the screen is old
  kEnded,      ///< the capture has ended: no more images come
};

/// Counts and figures of a running capture. Refusals have the short words of `IngestReport::reason` as keys.
struct CaptureFigures {
  std::uint64_t frames_received = 0;  ///< accepted, refused, withdrawn and waiting
  std::uint64_t frames_accepted = 0;  ///< held-out ones included
  std::uint64_t frames_held_out = 0;
  std::map<std::string, std::uint64_t> frames_refused;
  std::uint64_t frames_withdrawn = 0;
  std::uint64_t frames_waiting = 0;  ///< kept, and not in the model yet
  std::uint64_t tracker_judged = 0;  ///< frames of the camera, as the tracker says; most are never sent
  std::map<std::string, std::uint64_t> tracker_refused;
  double images_per_s = 0;
  std::optional<double> residual;           ///< relative, of the last image: 0..1
  std::optional<double> predicted_psnr_db;  ///< of the last image, from those before it
  std::optional<double> held_out_psnr_db;
  std::optional<double> held_out_ssim;
  Trade trade;
};

/// Where an image is needed most.
struct NextView {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< object frame, metres
  std::string reason;                             ///< shown as it stands; may be empty
  bool well_known = false;                        ///< nothing needs an image: the person is told that this is all
};

/// What the person waits for, with a bar.
struct WorkInHand {
  std::string what;     ///< shown as it stands
  double fraction = 0;  ///< of the work that is done, 0..1
  std::string way_out;  ///< how to go without it; may be empty
};

/// All that the window shows at one moment: plain data, filled by whoever drives it. Every part may be absent.
struct ViewerState {
  std::shared_ptr<const ModelSnapshot> snapshot;
  std::shared_ptr<const Capture> capture;  ///< last camera image, with its camera, pose and tags
  std::optional<CaptureFigures> figures;
  TrackerLink link = TrackerLink::kNone;
  std::optional<NextView> next_view;
  std::optional<WorkInHand> work;
  bool paused = false;  ///< from another desk: images are stored and not added
  std::string message;  ///< one line for the person at the screen
  std::string trouble;  ///< shown large: why the tracker refuses what the camera sees; else empty
};

}  // namespace sheen
