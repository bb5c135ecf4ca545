// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/bit_model.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr std::int32_t kFastBits = 20, kSlowBits = 255;  ///< bits that the means reach over
constexpr std::int32_t kTrust = 24000, kMixing = 12;     ///< first weight, and how fast weights learn

constexpr int kProbabilities = 1 << 12;
constexpr int kLogits = 1 << 11;  ///< 256ths, to both sides of zero

struct Tables {
  std::array<std::int16_t, kProbabilities> logit;
  std::array<std::int16_t, 2 * kLogits> probability;

  Tables() {
    for (int i = 0; i < kProbabilities; ++i) {
      const double p = (i + 0.5) / kProbabilities;
      logit[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(
          std::clamp<long>(std::lround(256 * std::log(p / (1 - p))), 1 - kLogits, kLogits - 1));
    }
    for (int i = 0; i < 2 * kLogits; ++i) {
      const double p = 1 / (1 + std::exp((kLogits - i) / 256.0));
      probability[static_cast<std::size_t>(i)] =
          static_cast<std::int16_t>(std::clamp<long>(std::lround(kProbabilities * p), 1, kProbabilities - 1));
    }
  }
};

const Tables& tables() {
  static const Tables made;
  return made;
}

std::uint8_t zeros_of_256(std::int32_t ones, int of_bits) {
  const std::int32_t zeros = ((std::int32_t{1} << of_bits) - ones + (1 << (of_bits - 9))) >> (of_bits - 8);
  return static_cast<std::uint8_t>(std::clamp<std::int32_t>(zeros, 1, 255));
}

}  // namespace

BitModel::BitModel(int contexts, int mixers) : contexts_(static_cast<std::size_t>(contexts)) {
  Weights trust;
  trust.fill(kTrust);
  mixers_.assign(static_cast<std::size_t>(mixers), trust);
}

void BitModel::Context::learn(bool one) {
  const std::int32_t target = one ? (1 << 16) - 1 : 0;
  seen = std::min(seen + 1, kSlowBits);
  fast += 2 * (target - fast) / (2 * std::min(seen, kFastBits) + 1);
  slow += 2 * (target - slow) / (2 * seen + 1);
}

std::uint8_t BitModel::zeros_of_256(std::span<const int> contexts, int mixer) {
  count_ = contexts.size();
  for (std::size_t i = 0; i < count_; ++i) at_[i] = &contexts_[static_cast<std::size_t>(contexts[i])];
  if (count_ == 1) return sheen::zeros_of_256(at_[0]->fast + at_[0]->slow, 17);

  weights_ = &mixers_[static_cast<std::size_t>(mixer)];
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    logits_[i] = tables().logit[static_cast<std::size_t>((at_[i]->fast + at_[i]->slow) >> 5)];
    sum += std::int64_t{(*weights_)[i]} * logits_[i];
  }
  const std::int64_t mixed = std::clamp<std::int64_t>(sum >> 16, 1 - kLogits, kLogits - 1);
  ones_ = tables().probability[static_cast<std::size_t>(mixed + kLogits)];
  return sheen::zeros_of_256(ones_, 12);
}

void BitModel::learn(bool one) {
  if (count_ > 1) {
    const std::int32_t error = kMixing * ((one ? kProbabilities : 0) - ones_);
    for (std::size_t i = 0; i < count_; ++i) {
      std::int32_t& weight = (*weights_)[i];
      weight = std::clamp(weight + ((logits_[i] * error + (1 << 15)) >> 16), -(1 << 22), 1 << 22);
    }
  }
  for (std::size_t i = 0; i < count_; ++i) at_[i]->learn(one);
}

}  // namespace sheen
