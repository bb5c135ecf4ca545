// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_loop.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "reconstructor/capture/background_threads.h"
#include "reconstructor/capture/capture_storing.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kPoll{50};
constexpr int kLateSnapshotFactor = 5;
constexpr int kSnapshotsRest = 2;         // times as long as the last snapshot took, before the next
constexpr std::size_t kMostTimed = 4096;  // images whose latency is measured while they wait
constexpr int kJudgementsRest = 4;        // times as long as the last live judgement took, before the next

double seconds_since(std::int64_t steady_ns) {
  return 1e-9 * static_cast<double>(steady_now_ns() - steady_ns);
}

}  // namespace

CaptureLoop::CaptureLoop(const std::filesystem::path& session_folder, Session session,
                         std::unique_ptr<TrackerLinks> links, Reconstruction& reconstruction,
                         const CaptureLoopOptions& options, LoopObserver observer)
    : folder_(session_folder),
      session_(std::move(session)),
      reconstruction_(reconstruction),
      options_(options),
      observer_(std::move(observer)),
      links_(std::move(links)) {
  status_.journaled = session_.size();
  effort_record_ = session_.metadata(kEffortKey).value_or("");
}

CaptureLoop::~CaptureLoop() {
  stop();
}

void CaptureLoop::start() {
  const auto end = [this](const std::exception_ptr& error) { fail(words_of(error)); };
  receive_thread_ = guarded_thread([this] { receive(stop_receiving_.get_token()); }, end);
  ingest_thread_ =
      guarded_thread([this] { BackgroundThreads().run([this] { ingest(stop_ingesting_.get_token()); }); }, end);
}

void CaptureLoop::finish() {
  stop_receiving_.request_stop();
  if (receive_thread_.joinable()) receive_thread_.join();
  const std::lock_guard lock(mutex_);
  finishing_ = true;
}

void CaptureLoop::stop() {
  stop_receiving_.request_stop();
  stop_ingesting_.request_stop();
  journaled_changed_.notify_all();
  if (receive_thread_.joinable()) receive_thread_.join();
  if (ingest_thread_.joinable()) ingest_thread_.join();
}

/// What only shows or judges the capture cannot end it.
template <typename Watching>
bool CaptureLoop::unharmed(const Watching& watching) {
  return guarded(watching, [this](const std::exception_ptr& error) {
    const std::string what = words_of(error);
    watchers_log_.tell(what, "the capture goes on, though whoever watches it has failed: " + what);
  });
}

void CaptureLoop::receive(std::stop_token stop) {
  std::uint64_t journaled = status().journaled;
  while (!stop.stop_requested()) {
    std::optional<TrackerLinks::Arrival> arrival = links_->next(kPoll);
    if (arrival && !store(*arrival, journaled, stop)) return;
    unharmed([&] { report_links(arrival, journaled); });
    // After it is stored and acknowledged: tracker and model do not wait for those who watch.
    if (arrival && observer_.on_capture) unharmed([&] { observer_.on_capture(arrival->received.capture); });
  }
}

/// False where a capture could not be stored: it is not acknowledged, so the tracker keeps it for the next start.
bool CaptureLoop::store(TrackerLinks::Arrival& arrival, std::uint64_t& journaled, const std::stop_token& stop) {
  if (arrival.received.live) return true;
  if (hold_out_next_.exchange(false)) arrival.received.capture.purpose = Purpose::kHeldOut;
  try {
    arrival.stored_as = store_capture(session_, *links_, arrival, stop);
    const bool is_new = arrival.stored_as && *arrival.stored_as >= journaled;
    if (is_new && paused_) session_.set_withdrawn(*arrival.stored_as, true);
    if (is_new) journaled = *arrival.stored_as + 1;
  } catch (const SessionBusy&) {
    return false;  // asked to stop while it waited
  } catch (const std::exception& error) {
    fail(error.what());
    return false;
  }
  return true;
}

void CaptureLoop::report_links(const std::optional<TrackerLinks::Arrival>& arrival, std::uint64_t journaled) {
  std::vector<LinkState> links = links_->states();
  if (observer_.on_link) observer_.on_link(links);
  const std::lock_guard lock(mutex_);
  status_.links = std::move(links);
  status_.journaled = journaled;
  if (arrival && arrival->stored_as) {
    if (const std::optional<ClockOffset>& clock = status_.links[arrival->tracker].stats.clock) {
      const std::int64_t grabbed_ns = arrival->received.capture.times.grabbed_ns - clock->offset_ns;
      status_.latency.to_disk.add(seconds_since(grabbed_ns));
      if (arrival->stored_as >= status_.ingested) grabbed_ns_[*arrival->stored_as] = grabbed_ns;  // or sent twice
      if (grabbed_ns_.size() > kMostTimed) grabbed_ns_.erase(grabbed_ns_.begin());
    }
  }
  journaled_changed_.notify_all();
}

/// What the ingest thread has not shown and not judged yet, and since when.
struct CaptureLoop::Pending {
  Clock::duration judge_interval, snapshot_took{};
  bool unshown = false, unjudged = false;  // changes of the model
  Clock::time_point last_change = Clock::now(), last_shown = last_change, last_judged = last_change;

  void model_changed() {
    unshown = unjudged = true;
    last_change = Clock::now();
  }
};

void CaptureLoop::ingest(std::stop_token stop) {
  try {
    const Session journal = patiently(stop, [&] { return Session::open_read_only(folder_); });
    Pending pending{.judge_interval = options_.judge_interval};
    for (std::uint64_t next = 0; !stop.stop_requested();) {
      const Waited waited = wait_for_capture(next, stop);
      apply_withdrawals(journal, next, pending);  // one that was withdrawn as it came is never added
      if (go_over_when_asked(next)) pending.model_changed();
      const bool over = waited == Waited::kOver, ended = over || waited == Waited::kSourceEnded;
      if (waited == Waited::kArrived) {
        ingest_next(journal, next++);
        pending.model_changed();
      } else if (inexact_ && (ended || Clock::now() - pending.last_change >= options_.pause)) {
        begin_rebuild(next);
      }
      if (next < rebuild_until_) continue;  // the last whole model stays on the screen
      const bool late = behind(next);
      show_when_due(late, ended, pending);
      if (over && !mesh_to_come() &&
          patiently(stop, [&] { return journal.withdrawals_after(last_withdrawal_); }).empty())
        break;
      judge_when_due(late, pending);
    }
  } catch (const SessionBusy&) {
    if (!stop.stop_requested()) throw;
  }
  finished_ = true;
}

/// Takes images out of the model that were withdrawn since the last call, or begins to rebuild it.
void CaptureLoop::apply_withdrawals(const Session& journal, std::uint64_t& next, Pending& pending) {
  Followed followed = Followed::kMustRebuild;
  try {
    followed = follow_withdrawals(journal, next);
  } catch (const DamagedCapture&) {  // what it did to the model cannot be told from its file any more
  }
  if (followed == Followed::kMustRebuild) begin_rebuild(next);
  if (followed == Followed::kTakenOut) {
    pending.model_changed();
    show(pending);
  }
}

/// Images come first: while some wait (`late`), pictures of the model are rarer.
void CaptureLoop::show_when_due(bool late, bool ended, Pending& pending) {
  const auto interval = std::max<Clock::duration>((late ? kLateSnapshotFactor : 1) * options_.snapshot_interval,
                                                  kSnapshotsRest * pending.snapshot_took);
  if (pending.unshown && (ended || Clock::now() - pending.last_shown >= interval)) show(pending);
}

void CaptureLoop::show(Pending& pending) {
  const auto begun = Clock::now();
  pending.unshown = !unharmed([this] {
    if (observer_.on_snapshot) observer_.on_snapshot(reconstruction_.snapshot(), reconstruction_.shared_painter());
  });
  {
    const std::lock_guard lock(mutex_);
    for (const std::int64_t grabbed_ns : std::exchange(unshown_grabbed_ns_, {}))
      if (observer_.on_snapshot && !pending.unshown) status_.latency.to_picture.add(seconds_since(grabbed_ns));
  }
  pending.last_shown = Clock::now();
  pending.snapshot_took = pending.last_shown - begun;
}

/// Images come first: while some wait (`late`), nothing is judged.
void CaptureLoop::judge_when_due(bool late, Pending& pending) {
  if (!pending.unjudged || late || Clock::now() - pending.last_judged < pending.judge_interval) return;
  const auto begun = Clock::now();
  unharmed([this] { judge_live(); });
  pending.last_judged = Clock::now();
  pending.judge_interval =
      std::max<Clock::duration>(options_.judge_interval, kJudgementsRest * (pending.last_judged - begun));
  pending.unjudged = false;
}

CaptureLoop::Waited CaptureLoop::wait_for_capture(std::uint64_t index, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  journaled_changed_.wait_for(lock, stop, kPoll, [&] { return status_.journaled > index; });
  if (status_.journaled > index) return Waited::kArrived;
  const bool ended = status_.link().ended;
  status_.no_more_captures = finishing_ || (ended && options_.stop_when_source_ends);
  if (status_.no_more_captures) return Waited::kOver;
  return ended ? Waited::kSourceEnded : Waited::kNothing;
}

CaptureLoop::Followed CaptureLoop::follow_withdrawals(const Session& journal, std::uint64_t ingested) {
  const std::vector<Withdrawal> news =
      patiently(stop_ingesting_.get_token(), [&] { return journal.withdrawals_after(last_withdrawal_); });
  if (news.empty()) return Followed::kNothing;
  last_withdrawal_ = news.back().number;
  std::set<std::uint64_t> now = withdrawn_;
  for (const Withdrawal& w : news) {
    if (w.withdrawn)
      now.insert(w.capture);
    else
      now.erase(w.capture);
  }
  std::swap(now, withdrawn_);
  Followed followed = Followed::kNothing;
  std::set<std::uint64_t> looked_at;
  for (const Withdrawal& w : news) {
    const bool changed = w.capture < ingested && now.contains(w.capture) != withdrawn_.contains(w.capture);
    if (!changed || !looked_at.insert(w.capture).second) continue;
    if (!withdrawn_.contains(w.capture)) return Followed::kMustRebuild;
    const Reconstruction::Withdrawn how = reconstruction_.withdraw(journal.read(w.capture));
    const bool rebuilding = ingested < rebuild_until_;
    if (how == Reconstruction::Withdrawn::kNot || (how == Reconstruction::Withdrawn::kNearly && rebuilding))
      return Followed::kMustRebuild;
    if (how == Reconstruction::Withdrawn::kNearly) inexact_ = true;
    followed = Followed::kTakenOut;
  }
  if (followed == Followed::kNothing) return followed;
  const std::lock_guard lock(mutex_);
  status_.exact = !inexact_ && ingested >= rebuild_until_;
  status_.counts = reconstruction_.account().counts();
  return followed;
}

void CaptureLoop::go_over_to(std::shared_ptr<const Mesh> mesh) {
  const std::lock_guard lock(mutex_);
  next_mesh_ = std::move(mesh);
}

void CaptureLoop::no_other_mesh_follows() {
  const std::lock_guard lock(mutex_);
  mesh_is_final_ = true;
}

void CaptureLoop::tell(std::optional<MeshLook> look) {
  const std::lock_guard lock(mutex_);
  status_.mesh_look = look;
}

bool CaptureLoop::mesh_to_come() const {
  const std::lock_guard lock(mutex_);
  return next_mesh_ || (options_.awaits_last_mesh && !mesh_is_final_);
}

/// Whether another mesh was asked for.
bool CaptureLoop::go_over_when_asked(std::uint64_t& next) {
  std::shared_ptr<const Mesh> mesh;
  {
    const std::lock_guard lock(mutex_);
    mesh = std::exchange(next_mesh_, nullptr);
    if (mesh) status_.on_another_mesh = true;
  }
  if (mesh) begin_rebuild(next, mesh);
  return mesh != nullptr;
}

/// What an image left in others goes only when the model is rebuilt.
void CaptureLoop::begin_rebuild(std::uint64_t& next, const std::shared_ptr<const Mesh>& mesh) {
  if (mesh)
    reconstruction_.restart_on(mesh);
  else
    reconstruction_.restart();
  rebuild_until_ = std::max(rebuild_until_, next);
  next = 0;
  inexact_ = false;
  const std::lock_guard lock(mutex_);
  status_.exact = false;
}

/// Whether captures wait to be ingested.
bool CaptureLoop::behind(std::uint64_t next) const {
  const std::lock_guard lock(mutex_);
  return status_.journaled > next;
}

/// One damaged file stops neither this capture nor the next start.
IngestReport CaptureLoop::ingest_if_whole(const Session& journal, std::uint64_t index) {
  try {
    return reconstruction_.ingest(patiently(stop_ingesting_.get_token(), [&] { return journal.read(index); }));
  } catch (const DamagedCapture& error) {
    log_error("session", std::string("left out: ") + error.what());
    reconstruction_.refuse_damaged(1);
    return {.status = IngestStatus::kRefused};
  }
}

void CaptureLoop::ingest_next(const Session& journal, std::uint64_t index) {
  IngestReport report;
  if (withdrawn_.contains(index))
    reconstruction_.leave_out(1);
  else
    report = ingest_if_whole(journal, index);
  if (std::string record = reconstruction_.effort_record(); record != effort_record_) {
    patiently(stop_ingesting_.get_token(), [&] { session_.set_metadata(kEffortKey, record); });
    effort_record_ = std::move(record);
  }
  const std::lock_guard lock(mutex_);
  status_.ingested = index + 1;
  status_.rebuild_until = status_.ingested < rebuild_until_ ? rebuild_until_ : 0;
  if (status_.rebuild_until == 0) status_.on_another_mesh = false;
  status_.exact = !inexact_ && status_.rebuild_until == 0;
  status_.counts = reconstruction_.account().counts();
  const auto grabbed = grabbed_ns_.extract(index);
  if (report.status == IngestStatus::kAccepted) {
    status_.last = report;
    if (grabbed) {
      status_.latency.to_model.add(seconds_since(grabbed.mapped()));
      if (unshown_grabbed_ns_.size() < kMostTimed) unshown_grabbed_ns_.push_back(grabbed.mapped());
    }
  }
  status_.images_per_s = reconstruction_.account().images_per_s();
  status_.trade = reconstruction_.trade(status_.trade.health);
}

void CaptureLoop::judge_live() {
  const std::vector<HeldOutView>& views = reconstruction_.held_out();
  const Eigen::Vector3d centre = bounding_sphere(reconstruction_.mesh()).centre.cast<double>();
  if (const std::vector<std::size_t> panel = judging_panel(views, centre); !panel.empty())
    held_out_curve_.judge(views, panel, reconstruction_.account().counts().accepted,
                          *reconstruction_.snapshot()->filled(), *reconstruction_.model().constant_colour(),
                          reconstruction_.painter());
  const ModelFigures figures = reconstruction_.model().figures();
  const NumericalHealth health = reconstruction_.health();
  const std::lock_guard lock(mutex_);
  status_.held_out_curve = held_out_curve_.points();
  status_.rank_histogram = figures.rank_histogram;
  status_.model_bytes = figures.bytes;
  status_.trade.health = health;
  for (const auto& [stage, seconds] : reconstruction_.account().stages()) status_.stage_s[stage] = seconds.median_s();
  status_.update = reconstruction_.account().updates();
}

void CaptureLoop::fail(const std::string& what) {
  {
    const std::lock_guard lock(mutex_);
    status_.error = what;
  }
  stop_receiving_.request_stop();
  stop_ingesting_.request_stop();
  finished_ = true;
}

std::optional<std::uint64_t> CaptureLoop::withdraw_last() {
  const std::optional<std::uint64_t> last = session_.last();
  if (last) session_.set_withdrawn(*last, true);
  return last;
}

void CaptureLoop::write_down(const std::string& key, const std::string& line) {
  session_.set_metadata(key, session_.metadata(key).value_or("") + line + "\n");
}

LoopStatus CaptureLoop::status() const {
  const std::lock_guard lock(mutex_);
  LoopStatus now = status_;
  now.paused = paused_;
  return now;
}

}  // namespace sheen
