// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/base/sparing_log.h"
#include "common/session/session.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/capture/tracker_links.h"
#include "reconstructor/evaluation/held_out_curve.h"

namespace sheen {

/// Metadata of a session: `Reconstruction::effort_record` of the daemon that captured it.
inline constexpr const char* kEffortKey = "effort";

/// What the loop tells its observers; plain values, copied.
/// From the grab of a frame, by the measured offset of the two machines' clocks; captures that came while there was
/// none are not in it.
struct Latencies {
  RunningStatistics to_disk;     ///< durable here
  RunningStatistics to_model;    ///< in the model; of images that it took
  RunningStatistics to_picture;  ///< of these: in a snapshot that whoever watches has
};

/// How far a look at the captures so far, for a better mesh, has come.
struct MeshLook {
  std::uint64_t captures = 0;
  std::size_t done = 0, steps = 0;
};

struct LoopStatus {
  FrameCounts counts;
  std::uint64_t journaled = 0;        ///< captures that are durable
  std::uint64_t ingested = 0;         ///< of these, how many the model has seen or left out
  std::uint64_t rebuild_until = 0;    ///< while the model is being rebuilt: of how many captures; else 0
  bool on_another_mesh = false;       ///< why: another mesh; else a withdrawal
  std::optional<MeshLook> mesh_look;  ///< while there is one
  bool no_more_captures = false;      ///< all that will come are durable
  bool paused = false;                ///< what comes is withdrawn at once
  /// Captures that are durable and not in the model yet: journaled = accepted + held out + refused + withdrawn + these.
  std::uint64_t waiting() const { return journaled - std::min(journaled, ingested); }
  /// False from a withdrawal until the model is, to the bit, one that never saw the image.
  bool exact = true;
  std::vector<LinkState> links;                         ///< to each tracker
  ReceiverStats link() const { return joined(links); }  ///< as one
  IngestReport last;
  double images_per_s = 0;
  Trade trade;
  std::vector<std::size_t> rank_histogram;
  std::uint64_t model_bytes = 0;
  std::map<std::string, double> stage_s;  ///< median per stage
  RunningStatistics update;               ///< of the model by an image
  Latencies latency;
  /// Live figures on views the model never saw.
  std::vector<HeldOutPoint> held_out_curve;
  std::string error;  ///< what stopped the loop, if anything did (a full disk, say)
};

/// Who watches a loop. Calls come from the loop's threads and must be quick. What they throw is logged, and ends
/// nothing.
struct LoopObserver {
  /// With a painter of its mesh.
  std::function<void(std::shared_ptr<const ModelSnapshot>, std::shared_ptr<const RayPainter>)> on_snapshot;
  std::function<void(const Capture&)> on_capture;              ///< every capture that arrives, live or to be kept
  std::function<void(const std::vector<LinkState>&)> on_link;  ///< many times per second, from the start
};

struct CaptureLoopOptions {
  std::chrono::milliseconds snapshot_interval{400};  ///< at most this often, and less often where one takes long
  std::chrono::milliseconds judge_interval{1500};    ///< at least, between live judgements of a model that changes
  std::chrono::milliseconds pause{2000};  ///< without a capture, after which there is time to rebuild a model
  bool stop_when_source_ends = false;
  bool awaits_last_mesh = false;  ///< not finished before `no_other_mesh_follows`
};

/// The live loop. Two threads and a journal between them:
///   receive:  link -> journal (durable) -> acknowledge
///   ingest:   journal -> model -> snapshot -> observers; now and then some held-out views judge what has changed
/// The model is a function of the journal alone: after a crash the same captures in the same order give the same model,
/// and a slow model only lags behind; nothing is lost and nothing waits for it. A capture whose file is damaged counts
/// as refused. While another program keeps the session locked, captures wait unacknowledged. When a capture that the
/// model knows is withdrawn from the journal, by whichever program, it is taken out of the model at once, and in the
/// next pause of the capture the model is rebuilt without it, to the bit, while the last snapshot stays. So it is at
/// once where a better mesh comes.
class CaptureLoop {
 public:
  /// The session's captures so far are ingested first. `links`: that know what the session holds.
  CaptureLoop(const std::filesystem::path& session_folder, Session session, std::unique_ptr<TrackerLinks> links,
              Reconstruction& reconstruction, const CaptureLoopOptions& options, LoopObserver observer);
  ~CaptureLoop();

  void start();
  /// No more captures are taken from the link; the loop has finished once those in the journal are in the model, and
  /// what was taken back is out of it, to the bit.
  void finish();
  /// Asks the loop to end and waits for it; what is journaled but not ingested yet is left to the next start.
  void stop();
  /// True when nothing more comes and everything has been ingested, or an error stopped the loop.
  bool finished() const { return finished_; }
  /// The model is rebuilt on another mesh, while the last snapshot stays. From any thread.
  void go_over_to(std::shared_ptr<const Mesh> mesh);
  void no_other_mesh_follows();
  /// What `LoopStatus::mesh_look` says; nothing when it is over.
  void tell(std::optional<MeshLook> look);
  LoopStatus status() const;
  /// Withdraws the last capture of the journal that is not withdrawn, and returns its index; nothing where there is
  /// none. Throws FileError.
  std::optional<std::uint64_t> withdraw_last();
  /// The next capture that comes is stored as held out.
  void hold_out_next() { hold_out_next_ = true; }
  /// Captures that come from now on are stored and withdrawn at once, until `go_on`.
  void pause() { paused_ = true; }
  void go_on() { paused_ = false; }
  /// Adds a line to a text of the session's metadata. Throws FileError.
  void write_down(const std::string& key, const std::string& line);

 private:
  struct Pending;
  void receive(std::stop_token stop);
  template <typename Watching>
  bool unharmed(const Watching& watching);
  bool store(TrackerLinks::Arrival& arrival, std::uint64_t& journaled, const std::stop_token& stop);
  void report_links(const std::optional<TrackerLinks::Arrival>& arrival, std::uint64_t journaled);
  void ingest(std::stop_token stop);
  void apply_withdrawals(const Session& journal, std::uint64_t& next, Pending& pending);
  void show_when_due(bool late, bool ended, Pending& pending);
  void show(Pending& pending);
  void judge_when_due(bool late, Pending& pending);
  enum class Waited { kArrived, kNothing, kSourceEnded, kOver };
  Waited wait_for_capture(std::uint64_t index, std::stop_token stop);
  bool behind(std::uint64_t next) const;
  IngestReport ingest_if_whole(const Session& journal, std::uint64_t index);
  void ingest_next(const Session& journal, std::uint64_t index);
  bool mesh_to_come() const;
  bool go_over_when_asked(std::uint64_t& next);
  void begin_rebuild(std::uint64_t& next, const std::shared_ptr<const Mesh>& mesh = nullptr);
  enum class Followed { kNothing, kTakenOut, kMustRebuild };
  /// Takes what is withdrawn out of the model, which has ingested so many captures, where that can be done at once.
  Followed follow_withdrawals(const Session& journal, std::uint64_t ingested);
  void judge_live();
  void fail(const std::string& what);

  std::filesystem::path folder_;
  Session session_;
  Reconstruction& reconstruction_;
  CaptureLoopOptions options_;
  LoopObserver observer_;
  std::unique_ptr<TrackerLinks> links_;

  mutable std::mutex mutex_;
  std::condition_variable_any journaled_changed_;
  bool finishing_ = false;
  std::shared_ptr<const Mesh> next_mesh_;  ///< that was asked for and is not gone over to yet
  bool mesh_is_final_ = false;
  LoopStatus status_;
  std::set<std::uint64_t> withdrawn_;
  std::uint64_t last_withdrawal_ = 0;  ///< number of the last entry that is followed
  bool inexact_ = false;               ///< an image was taken out of the finished model
  std::uint64_t rebuild_until_ = 0;    ///< captures that the model knew when it was last begun again
  HeldOutCurve held_out_curve_;
  /// When captures were grabbed, by this machine's clock: those that wait for the model, by index, and those in it that
  /// no snapshot shows yet.
  std::map<std::uint64_t, std::int64_t> grabbed_ns_;
  std::vector<std::int64_t> unshown_grabbed_ns_;
  SparingLog watchers_log_{"display"};
  std::string effort_record_;  ///< as the session has it
  std::atomic<bool> finished_{false}, hold_out_next_{false}, paused_{false};
  // Not the threads' own: either may ask both to stop while `start` still assigns them.
  std::stop_source stop_receiving_, stop_ingesting_;
  std::jthread receive_thread_, ingest_thread_;
};

}  // namespace sheen
