// SPDX-License-Identifier: Apache-2.0
#include "common/link/retained_captures.h"

#include <algorithm>
#include <utility>

#include "common/base/errors.h"

namespace sheen {

RetainedCaptures::RetainedCaptures(std::string source_session, std::uint64_t sent_before)
    : source_session_(std::move(source_session)), sent_before_(sent_before) {}

std::uint64_t RetainedCaptures::first_sequence() const {
  return kept_.empty() ? std::max(last_sequence_, durable_) + 1 : kept_.front().sequence;
}

RetainedCaptures::Kept* RetainedCaptures::find(std::uint64_t sequence) {
  if (kept_.empty() || sequence < kept_.front().sequence) return nullptr;
  const std::uint64_t at = sequence - kept_.front().sequence;
  return at < kept_.size() ? &kept_[at] : nullptr;
}

void RetainedCaptures::add(std::uint64_t sequence, Message message) {
  last_sequence_ = sequence;
  kept_.push_back({sequence, std::move(message)});
}

void RetainedCaptures::note_sent(Kept& kept) {
  kept.sent_before = true;
  last_sent_ = std::max(last_sent_, kept.sequence);
}

void RetainedCaptures::require_sent(std::uint64_t sequence, const char* field) const {
  const std::uint64_t sent = std::max({last_sent_, durable_, sent_before_});
  if (sequence > sent)
    throw ProtocolError(std::string(field) + ": says " + std::to_string(sequence) + " of " + source_session_ +
                        ", of which " + std::to_string(sent) + " were sent");
}

std::size_t RetainedCaptures::release_up_to(std::uint64_t sequence) {
  durable_ = std::max(durable_, sequence);
  const std::size_t before = kept_.size();
  while (!kept_.empty() && kept_.front().sequence <= durable_) kept_.pop_front();
  return before - kept_.size();
}

}  // namespace sheen
