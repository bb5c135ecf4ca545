// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <utility>

#include "reconstructor/render/gl/viewer_state.h"

namespace sheen {

/// Hands states from the capture loop to the window. The latest wins; neither side ever waits for the other.
class ViewerFeed {
 public:
  void publish(ViewerState state) {
    auto fresh = std::make_shared<const ViewerState>(std::move(state));
    const std::lock_guard lock(mutex_);
    latest_.swap(fresh);  // the old state is freed after the lock is released
  }

  /// Never null: an empty state before the first is published.
  std::shared_ptr<const ViewerState> latest() const {
    const std::lock_guard lock(mutex_);
    return latest_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const ViewerState> latest_ = std::make_shared<const ViewerState>();
};

}  // namespace sheen
