// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/build_verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kPredictedWell_db = 25;  // then the constant colour is right, not the model wrong
constexpr double kChance_db = 0.1;        // of few held-out views

}  // namespace

std::string worthless(const Reconstruction::Judgement& judged) {
  const double model = judged.model.psnr_db, constant = judged.constant.psnr_db;
  if (!std::isfinite(model) || !(model < constant - kChance_db) || model > kPredictedWell_db) return {};
  return format("the model predicts the held-out views worse (%.2f dB) than one colour for each place does (%.2f dB)",
                model, constant);
}

std::string mostly_unused(const FrameCounts& counts) {
  std::uint64_t refused = 0;
  auto commonest = counts.refused.end();
  for (auto reason = counts.refused.begin(); reason != counts.refused.end(); ++reason) {
    refused += reason->second;
    if (commonest == counts.refused.end() || reason->second > commonest->second) commonest = reason;
  }
  if (refused <= counts.accepted) return {};
  return format("%llu of %llu images could not be used, most of them because: ",
                static_cast<unsigned long long>(refused), static_cast<unsigned long long>(refused + counts.accepted)) +
         commonest->first;
}

}  // namespace sheen
