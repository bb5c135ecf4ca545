// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/effort_plan.h"

#include <algorithm>
#include <utility>

namespace sheen {

void EffortPlan::keep_within(const Limits& limits, const std::string& record, std::uint64_t captures,
                             MeasuredLevels measured) {
  limits_ = limits;
  measured_ = std::move(measured);
  if (limits.psnr_db && !measured_.empty()) target_level_ = level_reaching(measured_, *limits.psnr_db);
  if (!limits.image_ms) return;
  if (record.empty())
    control_.emplace(*limits.image_ms, levels_);
  else
    control_.emplace(*limits.image_ms, levels_, record, captures);
}

void EffortPlan::begin_again(std::uint64_t captures) {
  if (control_) control_->begin_again(captures);
  memory_level_.reset();
}

int EffortPlan::level() const {
  return std::max({target_level_, memory_level_.value_or(0), control_ ? control_->effort_level().value_or(0) : 0});
}

}  // namespace sheen
