// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "reconstructor/evaluation/held_out.h"

namespace sheen {

/// The held-out views that judge a capture, however long it is: when they take more memory than they may, every second
/// is let go, and from then on only half as many are kept, so that they stay spread over all of it.
class HeldOutSet {
 public:
  static constexpr std::size_t kFewest = 8;  ///< are kept whatever they take

  explicit HeldOutSet(double most_bytes = 128e6) : most_bytes_(most_bytes) {}

  /// Whether the next view is one to keep. To be asked once for each.
  bool takes_next() { return came_++ % every_ == 0; }
  void add(HeldOutView view);
  void erase(const std::string& source_session, std::uint64_t sequence);
  void clear() { *this = HeldOutSet(most_bytes_); }

  const std::vector<HeldOutView>& views() const { return views_; }
  double bytes() const;

 private:
  double most_bytes_;
  std::vector<HeldOutView> views_;
  std::size_t came_ = 0, every_ = 1;
};

}  // namespace sheen
