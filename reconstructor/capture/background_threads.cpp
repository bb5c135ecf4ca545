// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/background_threads.h"

#include <sys/resource.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#include <unistd.h>

#include <thread>
#include <vector>

#include "common/base/guarded_thread.h"
#include "common/base/log.h"

namespace sheen {
namespace {

constexpr int kNice = 10;  ///< about a tenth of the weight of a thread that also wants to run

/// On Linux a priority belongs to a thread, not to its process.
void lower_priority_of_this_thread() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

/// An arena whose every place is kept for threads of ours, so that none of TBB's own ever works in it. Ours wait there
/// for something that comes only at the end, and do meanwhile what there is to do.
struct BackgroundThreads::Impl {
  const int threads = tbb::info::default_concurrency();
  tbb::task_arena arena{threads, static_cast<unsigned>(threads)};
  tbb::task_group end;
  std::vector<std::jthread> helpers;
  tbb::task_handle not_ended;  // last: as long as it is there, the helpers wait

  Impl() {
    arena.execute([this] { not_ended = end.defer([] {}); });
    for (int i = 1; i < threads; ++i)
      helpers.push_back(guarded_thread(
          [this] {
            lower_priority_of_this_thread();
            arena.execute([this] { end.wait(); });
          },
          [](const std::exception_ptr& error) { log_error("model", "one thread less computes: " + words_of(error)); }));
  }
};

BackgroundThreads::BackgroundThreads() : impl_(std::make_unique<Impl>()) {}

BackgroundThreads::~BackgroundThreads() = default;

void BackgroundThreads::run(const std::function<void()>& work) {
  lower_priority_of_this_thread();
  impl_->arena.execute(work);
}

}  // namespace sheen
