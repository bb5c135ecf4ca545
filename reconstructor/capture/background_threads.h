// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

namespace sheen {

/// While it lives, the thread that made it and the workers that compute for it let every other thread go first: on two
/// cores a model that computes on both must not keep images from being received, or a tracker beside it from tracking.
/// What nobody else needs is theirs. Priorities stay lowered: to raise them again takes a right that users lack.
class BackgroundThreads {
 public:
  BackgroundThreads();
  ~BackgroundThreads();

 private:
  class Workers;
  std::unique_ptr<Workers> workers_;
};

}  // namespace sheen
