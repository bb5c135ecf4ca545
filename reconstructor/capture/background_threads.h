// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace sheen {

/// Threads that let every other one go first: on two cores a model that computes on both must not keep images from
/// being received, or a tracker beside it from tracking. What nobody else needs is theirs. They are its own, for as
/// long as it lives: a priority that was lowered can be raised again only with a right that users lack, so no thread
/// that draws or saves may ever be one of them.
class BackgroundThreads {
 public:
  BackgroundThreads();
  ~BackgroundThreads();

  /// On this thread, which is one of them from now on; what it does in parallel is done by the others. Throws what
  /// `work` throws.
  void run(const std::function<void()>& work);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
