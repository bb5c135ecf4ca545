// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/aravis_source.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <thread>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "tracker/sources/aravis_camera.h"
#include "tracker/sources/frame_ids.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kStale{150};  ///< without a frame; more where the frame period is long
constexpr double kStalePeriods = 1.8;
constexpr milliseconds kReopen{700};      ///< without a frame: a hiccup has ended by then
constexpr milliseconds kRetry{100};       ///< between attempts to open; each takes 2.5 s itself while nobody answers
constexpr milliseconds kCloseBound{500};  ///< closing a vanished camera takes 5 to 7.5 s: it is not waited for

/// Closes a camera in a thread of its own. The returned future is ready when that is done.
std::future<void> close_aside(std::shared_ptr<AravisCamera> camera) {
  std::packaged_task<void()> close([camera = std::move(camera)]() mutable { camera.reset(); });
  std::future<void> done = close.get_future();
  detached_thread(std::move(close), [](const std::exception_ptr&) {});  // the future has what it throws
  return done;
}

}  // namespace

struct AravisSource::Impl {
  std::string id;
  SourceSettings settings;
  std::shared_ptr<AravisCamera> camera;  ///< empty while it is being opened again; used by the thread of `next` only
  std::future<std::shared_ptr<AravisCamera>> reopening;
  std::shared_ptr<std::atomic<bool>> stopping = std::make_shared<std::atomic<bool>>(false);
  bool started = false;
  Clock::time_point last_frame = Clock::now();
  Exposure exposure;
  std::string warning;  ///< of the first connection
  std::optional<std::uint64_t> last_id;
  std::uint64_t closed_underruns = 0, closed_missing = 0, closed_foreign = 0;  ///< of connections that are gone

  mutable std::mutex mutex;
  SourceState state = SourceState::kStarting;
  SourceStats stats;

  milliseconds stale_after() const {
    const double rate = camera ? camera->frame_rate_hz() : 0;
    return rate > 0 ? std::max(kStale, milliseconds(static_cast<int>(kStalePeriods * 1000 / rate))) : kStale;
  }
  void set_state(SourceState value) {
    const std::lock_guard lock(mutex);
    state = value;
  }
  void adopt(std::shared_ptr<AravisCamera> opened);
  void start_reopening();
  void watch();
  void account(Frame& frame);
};

AravisSource::AravisSource(const std::string& id, const SourceSettings& settings) : impl_(std::make_unique<Impl>()) {
  impl_->id = id;
  impl_->settings = settings;
  impl_->adopt(std::make_shared<AravisCamera>(id, settings));
  if (const std::string changes = impl_->camera->changes(); !changes.empty())
    impl_->warning = "camera " + id + " was left set up for another use, and is set back: " + changes;
}

AravisSource::~AravisSource() {
  *impl_->stopping = true;
  if (impl_->camera) close_aside(std::move(impl_->camera)).wait_for(kCloseBound);
}

void AravisSource::Impl::adopt(std::shared_ptr<AravisCamera> opened) {
  camera = std::move(opened);
  Exposure now = camera->exposure();
  now.config_epoch = exposure.config_epoch;
  const bool changed = now.exposure_s != exposure.exposure_s || now.gain_db != exposure.gain_db ||
                       now.locked != exposure.locked || exposure.config_epoch == 0;
  if (changed) ++now.config_epoch;
  exposure = now;
  last_id.reset();
  last_frame = Clock::now();
}

/// Opens in a detached worker that shares nothing with this object but the flag that tells it to give up: opening
/// cannot be interrupted, and ending the daemon must not wait for it.
void AravisSource::Impl::start_reopening() {
  closed_underruns += camera->underruns();
  closed_missing += camera->missing_packets();
  closed_foreign += camera->foreign();
  close_aside(std::move(camera));
  std::packaged_task<std::shared_ptr<AravisCamera>()> open(
      [id = id, settings = settings, stopping = stopping]() -> std::shared_ptr<AravisCamera> {
        while (!*stopping) {
          try {
            auto camera = std::make_shared<AravisCamera>(id, settings);
            camera->start();
            return camera;
          } catch (const std::exception&) {  // it is not there yet, or there is no memory for it now
            std::this_thread::sleep_for(kRetry);
          }
        }
        return nullptr;
      });
  reopening = open.get_future();
  detached_thread(std::move(open), [](const std::exception_ptr&) {});  // the future has what it throws
}

void AravisSource::Impl::watch() {
  const auto silence = Clock::now() - last_frame;
  if (silence > stale_after()) set_state(SourceState::kStale);
  if (silence > std::max(kReopen, 2 * stale_after()) || camera->control_lost()) start_reopening();
}

void AravisSource::Impl::account(Frame& frame) {
  last_frame = Clock::now();
  frame.exposure = exposure;
  const std::lock_guard lock(mutex);
  state = SourceState::kLive;
  ++stats.frames;
  if (!frame.complete) ++stats.incomplete;
  if (last_id) stats.missed += frames_between(*last_id, frame.camera_frame_id);
  last_id = frame.camera_frame_id;
  if (stats.frames == 1) stats.first_frame_id = frame.camera_frame_id;
  stats.last_frame_id = frame.camera_frame_id;
  stats.underruns = closed_underruns + camera->underruns();
  stats.missing_packets = closed_missing + camera->missing_packets();
  stats.foreign = closed_foreign + camera->foreign();
}

std::optional<Frame> AravisSource::next(std::chrono::milliseconds timeout) {
  if (!impl_->started) {
    impl_->camera->start();
    impl_->started = true;
    impl_->last_frame = Clock::now();
  }
  if (!impl_->camera) {
    if (impl_->reopening.wait_for(timeout) != std::future_status::ready) return std::nullopt;
    impl_->adopt(impl_->reopening.get());
    const std::lock_guard lock(impl_->mutex);
    ++impl_->stats.reopened;
  }
  // Short enough to notice in time that frames have stopped.
  auto frame = impl_->camera->grab(std::min(timeout, milliseconds(20)));
  if (frame)
    impl_->account(*frame);
  else
    impl_->watch();
  return frame;
}

SourceState AravisSource::state() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->state;
}

std::string AravisSource::message() const {
  switch (state()) {
    case SourceState::kStarting:
      return "camera " + impl_->id + " is open, no frame yet";
    case SourceState::kLive:
      return "camera " + impl_->id + " delivers";
    default:
      return "camera " + impl_->id + " has stopped delivering; check its cable and power";
  }
}

std::string AravisSource::remarks() const {
  return impl_->warning;
}

SourceStats AravisSource::stats() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->stats;
}

}  // namespace sheen
