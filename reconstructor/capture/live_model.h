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

/// Processor time that the calling thread may spend on something: a share of what there is, saved up for a moment.
class ProcessorAllowance {
 public:
  /// Negative: owed.
  std::chrono::nanoseconds left();
  /// Also more than is left.
  void spend(const std::function<void()>& work);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kMostSaved{20};
  std::chrono::nanoseconds left_ = kMostSaved;
  Clock::time_point known_at_ = Clock::now();
};

/// The model of a running capture, for desks that draw it themselves. However many ask, answering takes a small part of
/// the processors' time. What has changed goes first, on credit; what another eye sees waits until it is paid.
class LiveModel : public ServedModel {
 public:
  /// Follows what the loop will show.
  void watch(const ModelKind& kind, LoopObserver& observer);

  bool there() const override;
  std::string_view page() const override;
  Answer scene() override;
  Answer changes_for(const DeskQuestion& question) override;

 private:
  Answer answer(const std::function<std::string(ModelStream&)>& bytes);

  mutable std::mutex mutex_;
  std::shared_ptr<ModelStream> stream_;  ///< used by one answer at a time
  std::shared_ptr<const ModelSnapshot> snapshot_;
  std::chrono::steady_clock::time_point since_;  ///< of what the stream does not follow yet, the oldest
  bool followed_ = true;                         ///< by the stream
  ProcessorAllowance allowance_;
};

}  // namespace sheen
