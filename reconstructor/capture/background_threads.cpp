// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/background_threads.h"

#include <sys/resource.h>
#include <tbb/task_scheduler_observer.h>
#include <unistd.h>

namespace sheen {
namespace {

constexpr int kNice = 10;  ///< about a tenth of the weight of a thread that also wants to run

/// On Linux a priority belongs to a thread, not to its process.
void lower_priority_of_this_thread() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

class BackgroundThreads::Workers : public tbb::task_scheduler_observer {
 public:
  Workers() { observe(true); }
  ~Workers() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) lower_priority_of_this_thread();
  }
};

BackgroundThreads::BackgroundThreads() {
  lower_priority_of_this_thread();
  workers_ = std::make_unique<Workers>();
}

BackgroundThreads::~BackgroundThreads() = default;

}  // namespace sheen
