// SPDX-License-Identifier: Apache-2.0
#include "common/base/quantity.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

/// `zero`: whether it may be 0.
double quantity(const std::string& option, const std::string& word, const std::string& takes,
                const std::map<std::string, double>& units, bool zero = false) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  std::string unit(end, word.data() + word.size());
  unit.erase(0, unit.find_first_not_of(' '));
  const auto known = units.find(unit);
  if (error != std::errc{} || known == units.end() || !(value > 0 || (zero && value == 0)) || !std::isfinite(value))
    throw ConfigError(option + " " + word + ": takes " + takes);
  return value * known->second;
}

}  // namespace

double parse_time_ms(const std::string& option, const std::string& word, const std::string& takes) {
  return quantity(option, word, takes, {{"ms", 1}, {"s", 1e3}});
}

double parse_decibels(const std::string& option, const std::string& word, const std::string& takes) {
  return quantity(option, word, takes, {{"dB", 1}}, true);
}

double parse_length_m(const std::string& option, const std::string& word, const std::string& takes) {
  constexpr double kLongest_m = 10;
  const double metres = quantity(option, word, takes, {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}});
  if (metres > kLongest_m) throw ConfigError(option + " " + word + ": takes " + takes + ", 10 m at most");
  return metres;
}

double parse_bytes(const std::string& option, const std::string& word, const std::string& takes) {
  return quantity(
      option, word, takes,
      {{"", 1}, {"B", 1}, {"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}});
}

std::array<int, 2> parse_image_size(const std::string& option, const std::string& word, int least) {
  constexpr int kMost = 16384;
  int width = 0, height = 0;
  const char* const end = word.data() + word.size();
  const auto [by, width_error] = std::from_chars(word.data(), end, width);
  const bool two = width_error == std::errc{} && by != end && *by == 'x';
  const auto [rest, height_error] = std::from_chars(two ? by + 1 : end, end, height);
  if (!two || height_error != std::errc{} || rest != end || std::min(width, height) < least ||
      std::max(width, height) > kMost)
    throw ConfigError(option + " " + word + ": takes WIDTHxHEIGHT, each of " + std::to_string(least) + ".." +
                      std::to_string(kMost) + " pixels, such as 1280x800");
  return {width, height};
}

std::string gigabytes(double bytes) {
  return format("%.3g GB", bytes / 1e9);
}

}  // namespace sheen
