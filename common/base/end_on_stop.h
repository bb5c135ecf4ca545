// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <thread>

namespace sheen {

/// For work that is given up when a stop signal arrives, however deep in a library it is: while one lives, the process
/// ends with exit status 1 and `message` on standard error when it has not ended by itself within 0.7 s of the signal.
/// Files are written beside their target and renamed, so none is left half. Needs `install_stop_signals`.
class EndOnStop {
 public:
  explicit EndOnStop(std::string message);
  EndOnStop(const EndOnStop&) = delete;
  EndOnStop& operator=(const EndOnStop&) = delete;

 private:
  std::jthread watcher_;
};

}  // namespace sheen
