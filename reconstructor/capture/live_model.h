// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>

#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/models/model_kind.h"
#include "reconstructor/monitor/served_model.h"

namespace sheen {

/// The model of a running capture, for desks that draw it themselves. However many ask, answering takes a small part of
/// the time: more often they are told to ask again.
class LiveModel : public ServedModel {
 public:
  /// Follows what the loop will show.
  void watch(const ModelKind& kind, LoopObserver& observer);

  bool there() const override;
  std::string_view page() const override;
  Answer scene() override;
  Answer changes_for(const DeskQuestion& question) override;

 private:
  using Clock = std::chrono::steady_clock;
  Answer answer(const std::function<std::string(ModelStream&)>& bytes);
  std::shared_ptr<const ModelSnapshot> latest() const;

  mutable std::mutex mutex_;
  std::shared_ptr<ModelStream> stream_;  ///< used by one answer at a time
  std::shared_ptr<const ModelSnapshot> snapshot_;
  Clock::time_point rests_until_;
};

}  // namespace sheen
