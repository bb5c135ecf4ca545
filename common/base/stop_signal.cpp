// SPDX-License-Identifier: Apache-2.0
#include "common/base/stop_signal.h"

#include <signal.h>

#include <atomic>

namespace sheen {
namespace {

// Written in a signal handler, read by other threads: only a lock-free atomic may be both.
std::atomic<int> g_signals = 0;
std::atomic<int> g_graceful = 1;
static_assert(std::atomic<int>::is_always_lock_free);

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

using Handler = void (*)(int);

Handler handler_of(int signal) {
  struct sigaction now = {};
  return sigaction(signal, nullptr, &now) == 0 ? now.sa_handler : SIG_DFL;
}

void set_handler(int signal, Handler handler) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

void on_signal(int) {
  if (++g_signals < g_graceful) return;
  for (const int signal : kSignals)
    if (handler_of(signal) == on_signal) set_handler(signal, SIG_DFL);
}

}  // namespace

void install_stop_signals(int graceful) {
  g_graceful = graceful;
  for (const int signal : kSignals)
    if (signal != SIGHUP || handler_of(signal) != SIG_IGN) set_handler(signal, on_signal);
}

int stop_signals() {
  return g_signals;
}

bool stop_requested() {
  return g_signals > 0;
}

void count_stop_signal() {
  ++g_signals;
}

void forget_stop_signals() {
  g_signals = 0;
}

}  // namespace sheen
