// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/held_out_set.h"

#include <utility>

namespace sheen {

void HeldOutSet::add(HeldOutView view) {
  views_.push_back(std::move(view));
  while (bytes() > most_bytes_ && views_.size() > kFewest) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < views_.size(); i += 2) {
      if (kept != i) views_[kept] = std::move(views_[i]);
      ++kept;
    }
    views_.resize(kept);
    every_ *= 2;
  }
}

void HeldOutSet::erase(const std::string& source_session, std::uint64_t sequence) {
  std::erase_if(views_, [&](const HeldOutView& view) {
    return view.source_session == source_session && view.sequence == sequence;
  });
}

double HeldOutSet::bytes() const {
  double bytes = 0;
  for (const HeldOutView& view : views_) bytes += static_cast<double>(view.packed.size());
  return bytes;
}

}  // namespace sheen
