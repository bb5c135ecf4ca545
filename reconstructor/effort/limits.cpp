// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/limits.h"

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/quantity.h"

namespace sheen {
namespace {

std::string text(double value, const char* unit) {
  return format("%.4g %s", value, unit);
}

}  // namespace

Limits parse_limits(const std::string& budget, const std::string& target, const std::string& memory) {
  Limits limits;
  if (!budget.empty()) limits.image_ms = parse_time_ms("--budget", budget, "the time per image, such as 33ms or 0.2s");
  if (!memory.empty())
    limits.bytes = parse_bytes("--memory", memory, "the memory that the model may use, such as 1GB or 500MB");
  if (!target.empty())
    limits.psnr_db = parse_decibels("--target", target, "the PSNR of held-out views to reach, such as 35dB");
  if (limits.psnr_db && !(*limits.psnr_db > 0)) throw ConfigError("--target " + target + ": must be more than 0dB");
  return limits;
}

std::string describe(const Limits& limits) {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
  if (limits.image_ms) add("at most " + text(*limits.image_ms, "ms per image"));
  if (limits.bytes) add("at most " + text(*limits.bytes / 1e6, "MB"));
  if (limits.psnr_db) add("at least " + text(*limits.psnr_db, "dB"));
  return out;
}

}  // namespace sheen
