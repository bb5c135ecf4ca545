// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/online_svd_options.h"

#include <algorithm>
#include <stdexcept>

namespace sheen {
namespace {

constexpr int kLargestBlock = 32;
constexpr int kWitnessesPerTerm = 12;  // rows: of a column that hides most, the others still outnumber the terms

/// Null when none is.
const char* broken_rule(const OnlineSvdOptions& options, int rows) {
  if (rows <= 0) return "online SVD: rows must be positive";
  if (options.max_rank < 1) return "online SVD: max_rank must be at least 1";
  if (options.internal_rank != 0 && options.internal_rank < options.max_rank)
    return "online SVD: internal_rank must be 0 or at least max_rank";
  if (options.block < 1 || options.block > kLargestBlock) return "online SVD: block must be 1..32";
  if (!(options.tolerance >= 0 && options.tolerance < 1)) return "online SVD: tolerance must be in [0, 1)";
  if (options.channels < 1 || options.channels > rows) return "online SVD: channels must be 1..rows";
  return nullptr;
}

}  // namespace

int OnlineSvdOptions::terms_kept() const {
  if (internal_rank > 0) return std::max(internal_rank, max_rank);
  return std::max(max_rank, std::min(32, std::max(2 * max_rank, max_rank + 8)));
}

int OnlineSvdOptions::witnesses(int rows) const {
  return std::min(rows / channels, kWitnessesPerTerm * terms_kept() / channels + 1) * channels;
}

OnlineSvdOptions OnlineSvdOptions::limited_to(int most_displayed, int most_kept, int most_in_block) const {
  OnlineSvdOptions limited = *this;
  limited.internal_rank = std::min(terms_kept(), most_kept);
  limited.max_rank = std::min({max_rank, most_displayed, most_kept});
  limited.block = std::min(block, most_in_block);
  return limited;
}

void require_valid(const OnlineSvdOptions& options, int rows) {
  if (const char* rule = broken_rule(options, rows)) throw std::invalid_argument(rule);
}

}  // namespace sheen
