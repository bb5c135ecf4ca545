// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/running_statistics.h"
#include "common/capture/held_out_point.h"
#include "common/capture/trade.h"

namespace sheen {

/// A summary of durations, seconds.
struct DurationSummary {
  std::uint64_t count = 0;
  double sum_s = 0, p50_s = 0, p95_s = 0, p99_s = 0;
};
DurationSummary summarize(const RunningStatistics& statistics);

enum class CaptureState : std::uint8_t {
  kWaiting,       ///< no frame has come yet
  kLive,          ///< frames are coming
  kStale,         ///< connected, but frames have stopped coming
  kDisconnected,  ///< a peer is gone
  kEnded,         ///< the source has ended
  kFinishing,     ///< waiting captures are added to the model
  kRefining,      ///< the mesh is refined a last time
  kSaving,
  kJudging,  ///< the finished model is compared with the held-out views
  kFailed,   ///< see `error`
  kStalled,  ///< the reconstructor itself has not said anything for a while
};

/// What a person who watches a capture is shown: plain values, independent of any model.
struct MonitorState {
  using Clock = std::chrono::steady_clock;

  std::string version;
  std::string model;         ///< its kind, for a person
  std::string model_reason;  ///< why it was chosen; empty where the scene names it
  std::string session_folder;
  std::string source_session;  ///< the tracker's name for what it sends
  std::string photometric;     ///< what is known of what the camera makes of light; empty: no image has come

  struct Link {
    std::string name;  ///< "tracker", ...
    std::string endpoint;
    bool connected = false;
    bool encrypted = false;
    std::string last_error;
    bool came = false;   ///< it has been connected since the start
    bool ended = false;  ///< it said that nothing more comes
  };
  std::vector<Link> links;
  bool ended = false;   ///< the source said that nothing more comes
  bool paused = false;  ///< what comes is stored and taken back at once
  /// What is done after the last image, and how much of it is done.
  struct Ending {
    CaptureState state = CaptureState::kFinishing;
    std::uint64_t done = 0, total = 0;
  };
  std::optional<Ending> ending;
  std::string error;                  ///< what stopped the capture, if anything did
  std::vector<std::string> warnings;  ///< what is doubtful in the scene, each with its remedy

  std::optional<Clock::time_point> last_frame;  ///< when a capture last arrived
  /// received = accepted + held out + refused + withdrawn + waiting
  std::uint64_t received = 0, accepted = 0, held_out = 0, withdrawn = 0, waiting = 0, journaled = 0;
  /// What the tracker says of its camera's frames: judged = kept + refused, most of which are never sent.
  struct Tracker {
    std::uint64_t judged = 0;
    std::map<std::string, std::uint64_t> refused;
    std::string trouble;  ///< why most of the latest were refused, for a person; else empty
  };
  Tracker tracker;
  std::uint64_t sequence_gaps = 0;               ///< captures that the tracker sent and nobody received
  std::map<std::string, std::uint64_t> refused;  ///< by reason
  double images_per_s = 0;                       ///< that the model ingests

  struct Queue {
    std::uint64_t depth = 0;
    std::uint64_t capacity = 0;  ///< 0: on disk, without a limit
  };
  std::map<std::string, Queue> queues;
  std::map<std::string, double> stage_s;                    ///< median per stage of an update
  DurationSummary update;                                   ///< of the model by an image
  DurationSummary latency, model_latency, picture_latency;  ///< from the grab until durable, in the model, and shown
  std::vector<std::size_t> rank_histogram;                  ///< patches of rank 0, 1, ...
  std::uint64_t model_bytes = 0;
  /// Of the surface, 0..1: what some image showed, and what is more than imputed. Empty: there is no model yet.
  struct Surface {
    double seen = 0, measured = 0;
  };
  std::optional<Surface> surface;
  /// Of the vertices of a shape that was found in the images, 0..1, by from what they are known (`ShapeEvidence`).
  struct Shape {
    double seen = 0, outlined = 0, guessed = 0;
  };
  std::optional<Shape> shape;  ///< empty: there is none yet, or the mesh was given
  Trade trade;

  std::vector<HeldOutPoint> held_out_curve;
  std::string next_view;    ///< where to hold the camera next, for a person
  bool well_known = false;  ///< nothing needs an image any more; `next_view` says why
  std::string steering;     ///< what was last asked from another desk, and done; empty: nothing
  std::string hint;         ///< what to do while nothing comes: a command
  std::string doing;        ///< what is done before there is a model, for a person; empty: nothing

  std::shared_ptr<const std::string> preview_jpeg;  ///< the model; null: none yet
  std::shared_ptr<const std::string> shape_jpeg;    ///< the mesh, coloured by its evidence; null: it has none
  std::string preview_note;                         ///< that no photograph is from there; empty: some are
  std::shared_ptr<const std::string> camera_jpeg;   ///< the newest camera image
};

const char* to_string(CaptureState state);

/// Frames that are older than this are called stale, and so is a reconstructor that published this long ago.
inline constexpr std::chrono::seconds kStaleAfter{3};

CaptureState capture_state(const MonitorState& state, MonitorState::Clock::time_point published,
                           MonitorState::Clock::time_point now);

}  // namespace sheen
