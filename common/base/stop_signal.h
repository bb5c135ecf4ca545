// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// From here on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) are counted instead of ending the
/// process; the one after the first `graceful` ends it at once.
void install_stop_signals(int graceful = 1);

/// How many of them have arrived.
int stop_signals();

/// Whether one of them has arrived. Loops look at it at least every 100 ms, so that Ctrl-C ends a daemon cleanly.
bool stop_requested();

// For work in a process whose signals are another's: a Python interpreter has handlers of its own.
void count_stop_signal();    ///< as if one had arrived
void forget_stop_signals();  ///< as if none had: the work has ended

}  // namespace sheen
