// SPDX-License-Identifier: Apache-2.0
#include "common/base/sparing_log.h"

#include "common/base/log.h"

namespace sheen {
namespace {

constexpr std::chrono::minutes kToldAgainAfter{1};
constexpr std::size_t kMostSubjects = 256;

}  // namespace

bool SparingLog::tell(const std::string& subject, std::string_view message) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(told_, [&](const auto& entry) { return now - entry.second >= kToldAgainAfter; });
  if (told_.size() >= kMostSubjects || !told_.insert({subject, now}).second) return false;
  log_warning(component_, message);
  return true;
}

}  // namespace sheen
