// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/limits.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/base/errors.h"

namespace sheen {
namespace {

/// A positive number followed by a unit; spaces between them are allowed.
std::optional<double> quantity(const std::string& word, const std::map<std::string, double>& units,
                               const std::string& option, const std::string& takes) {
  if (word.empty()) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  std::string unit(end, word.data() + word.size());
  unit.erase(0, unit.find_first_not_of(' '));
  const auto known = units.find(unit);
  if (error != std::errc{} || known == units.end() || !(value > 0) || !std::isfinite(value))
    throw ConfigError(option + " " + word + ": takes " + takes);
  return value * known->second;
}

std::string text(double value, const char* unit) {
  char out[48];
  std::snprintf(out, sizeof out, "%.4g %s", value, unit);
  return out;
}

}  // namespace

Limits parse_limits(const std::string& budget, const std::string& target, const std::string& memory) {
  static const std::map<std::string, double> times{{"ms", 1}, {"s", 1e3}};
  static const std::map<std::string, double> decibels{{"dB", 1}};
  static const std::map<std::string, double> sizes{{"B", 1},        {"kB", 1e3},     {"MB", 1e6},    {"GB", 1e9},
                                                   {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}};
  return {.image_ms = quantity(budget, times, "--budget", "the time that an image may take, such as 33ms or 0.2s"),
          .bytes = quantity(memory, sizes, "--memory", "the memory the light field may take, such as 1GB or 500MB"),
          .psnr_db = quantity(target, decibels, "--target", "the PSNR of held-out views to reach, such as 35dB")};
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
