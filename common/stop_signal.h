// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// From here on SIGINT and SIGTERM set a flag instead of ending the process; a second one ends it at once.
void install_stop_signals();

/// Whether one of them has arrived. Loops look at it at least every 100 ms, so that Ctrl-C ends a daemon cleanly.
bool stop_requested();

}  // namespace sheen
