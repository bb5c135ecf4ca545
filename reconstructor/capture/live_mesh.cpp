// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_mesh.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "reconstructor/capture/background_threads.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/capture_storing.h"
#include "reconstructor/capture/training_images.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPoll{100};

struct Stopped {};
struct Overtaken {};  ///< all captures have come, many more than are looked at

}  // namespace

LiveMesh::LiveMesh(CaptureLoop& loop, std::filesystem::path session_folder, LiveMeshOptions options, LookAtMesh look)
    : loop_(loop),
      folder_(std::move(session_folder)),
      options_(options),
      look_(std::move(look)),
      looks_(std::make_unique<nlohmann::json>(nlohmann::json::array())) {}

LiveMesh::~LiveMesh() = default;

void LiveMesh::start() {
  // Whatever goes wrong here, the capture ends with the mesh that it has.
  const auto give_up = [this](const std::exception_ptr& error) {
    loop_.tell(std::nullopt);
    loop_.no_other_mesh_follows();
    log_error("mesh", "it stays as it is: " + words_of(error));
  };
  thread_ = guarded_thread([this](const std::stop_token& stop) { run(stop); }, give_up);
}

nlohmann::json LiveMesh::report() const {
  const std::lock_guard lock(mutex_);
  return *looks_;
}

void LiveMesh::run(const std::stop_token& stop) {
  try {
    BackgroundThreads().run([&] { look_until_over(stop); });
  } catch (const Stopped&) {
  }
  loop_.tell(std::nullopt);
  loop_.no_other_mesh_follows();
}

void LiveMesh::look_until_over(const std::stop_token& stop) {
  std::uint64_t looked_at = 0, next = options_.first;
  for (bool over = false; !over;) {
    const LoopStatus status = wait_for(next, stop);
    over = status.no_more_captures;
    if (over && !many_more(status.journaled, looked_at)) return;
    try {
      if (const auto mesh = look(status, stop)) loop_.go_over_to(mesh);
      looked_at = status.journaled;
    } catch (const Overtaken&) {
    }
    loop_.tell(std::nullopt);
    next = static_cast<std::uint64_t>(std::ceil(options_.growth * static_cast<double>(status.journaled)));
  }
}

bool LiveMesh::many_more(std::uint64_t captures, std::uint64_t looked_at) const {
  return static_cast<double>(captures) >= options_.growth_at_end * static_cast<double>(looked_at);
}

/// Until there are so many captures, or no more come.
LoopStatus LiveMesh::wait_for(std::uint64_t captures, const std::stop_token& stop) const {
  for (;; std::this_thread::sleep_for(kPoll)) {
    if (stop.stop_requested() || loop_.finished()) throw Stopped();
    LoopStatus status = loop_.status();
    if (status.journaled >= captures || status.no_more_captures) return status;
  }
}

StepsDone LiveMesh::steps_of(const LoopStatus& begun, const std::stop_token& stop) {
  return [this, captures = begun.journaled, last = begun.no_more_captures, stop](std::size_t done, std::size_t steps) {
    if (stop.stop_requested() || loop_.finished()) throw Stopped();
    loop_.tell(MeshLook{captures, done, steps});
    const LoopStatus status = loop_.status();
    if (!last && status.no_more_captures && many_more(status.journaled, captures)) throw Overtaken();
  };
}

std::shared_ptr<const Mesh> LiveMesh::look(const LoopStatus& status, const std::stop_token& stop) {
  const auto begun = Clock::now();
  const CaptureSet captures = patiently(stop, [&] { return open_capture_set(folder_); });
  const RefinementImages images = training_images(captures, options_.hold_out_every);
  if (images.cameras.size() < options_.fewest_images) return nullptr;
  nlohmann::json told;
  std::shared_ptr<const Mesh> mesh = look_(images, steps_of(status, stop), told);
  const std::chrono::duration<double> took = Clock::now() - begun;
  told["images"] = images.cameras.size();
  told["seconds"] = took.count();
  const std::lock_guard lock(mutex_);
  looks_->push_back(std::move(told));
  return mesh;
}

void save_mesh_of_session(const std::filesystem::path& session_folder, const char* name,
                          const std::function<void(const std::filesystem::path& file)>& save) {
  const std::filesystem::path part = session_folder / (std::string("part_of_") + name);
  save(part);
  std::filesystem::rename(part, session_folder / name);
}

}  // namespace sheen
