// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "common/link/wire.h"

namespace sheen {

/// The kept captures of one run of a source that are on no receiver's disk yet: consecutive sequences. Not thread-safe.
class RetainedCaptures {
 public:
  using Message = std::shared_ptr<const EncodedCapture>;
  struct Kept {
    std::uint64_t sequence = 0;
    Message message;
    bool sent_before = false;
  };

  /// `sent_before`: so many of the run were sent by an earlier process.
  RetainedCaptures(std::string source_session, std::uint64_t sent_before);

  std::size_t size() const { return kept_.size(); }
  bool empty() const { return kept_.empty(); }
  std::uint64_t last_sequence() const { return last_sequence_; }
  std::uint64_t durable() const { return durable_; }
  /// The oldest that a receiver may still ask for; the next to come where none waits.
  std::uint64_t first_sequence() const;
  /// Null where it is not there (any more, or yet).
  Kept* find(std::uint64_t sequence);

  void add(std::uint64_t sequence, Message message);
  void note_sent(Kept& kept);
  /// Nobody holds what was never sent: throws ProtocolError naming the field that says so.
  void require_sent(std::uint64_t sequence, const char* field) const;
  /// A receiver's disk holds everything up to here. Returns how many were let go of.
  std::size_t release_up_to(std::uint64_t sequence);

 private:
  const std::string source_session_;
  const std::uint64_t sent_before_;
  std::deque<Kept> kept_;
  std::uint64_t last_sequence_ = 0, last_sent_ = 0, durable_ = 0;
};

}  // namespace sheen
