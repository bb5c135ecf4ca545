// SPDX-License-Identifier: Apache-2.0
#include "common/stop_signal.h"

#include <signal.h>

#include <atomic>

namespace sheen {
namespace {

// Written in a signal handler, read by other threads: only a lock-free atomic may be both.
std::atomic<bool> g_stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void on_signal(int) {
  g_stop = true;
}

}  // namespace

void install_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESETHAND;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stop_requested() {
  return g_stop;
}

}  // namespace sheen
