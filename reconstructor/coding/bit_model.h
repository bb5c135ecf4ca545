// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sheen {

/// How likely the next bit is a one: learned in contexts, and mixed where a bit stands in several at once. All of it is
/// whole numbers, so that a reader on any machine expects the same.
class BitModel {
 public:
  static constexpr std::size_t kMostContexts = 4;

  /// A mixer learns how far each of the contexts is to be trusted (logistic mixing: Mahoney 2005, as in PAQ).
  explicit BitModel(int contexts, int mixers = 0);

  /// Of 256, how likely a zero is; 1 to 255. `contexts`: up to kMostContexts; `mixer` is not used for a single one.
  std::uint8_t zeros_of_256(std::span<const int> contexts, int mixer);
  /// What the bit was that `zeros_of_256` was asked for last.
  void learn(bool one);

 private:
  /// A mean over the last bits, and one over more of them. Both are exact for the first bits, so that a context that is
  /// seldom used costs little.
  struct Context {
    std::int32_t fast = 1 << 15, slow = 1 << 15;  ///< of 2^16
    std::int32_t seen = 0;
    void learn(bool one);
  };
  using Weights = std::array<std::int32_t, kMostContexts>;  ///< of 2^16

  std::vector<Context> contexts_;
  std::vector<Weights> mixers_;
  // Of the bit that is asked for:
  std::array<Context*, kMostContexts> at_{};
  std::array<std::int32_t, kMostContexts> logits_{};
  Weights* weights_ = nullptr;  ///< where contexts are mixed
  std::size_t count_ = 0;
  std::int32_t ones_ = 0;  ///< expected, of 2^12
};

}  // namespace sheen
