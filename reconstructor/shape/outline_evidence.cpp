// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/outline_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr double kRim = 0.03;        // width of the rim, of the image's smaller side
constexpr double kMostOfRim = 0.97;  // is background
constexpr float kLeastSpread = 8;    // grey levels: noise of a camera in the dark
constexpr float kMostSpread = 96;
constexpr float kSure = 0.5f;  // of where object and background part: up to there it is surely background
constexpr double kLeastObject = 0.005, kMostObject = 0.9;  // of the image's pixels
constexpr double kApart = 0.75;  // of the variance of all pixels: explained by object and background being two

bool is_like(const PlainBackground& background, float grey) {
  return std::abs(grey - background.level) <= background.spread;
}

std::vector<double> rim_of(const ImageF& grey) {
  const int rim = std::max(1, static_cast<int>(kRim * std::min(grey.width(), grey.height())));
  std::vector<double> values;
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x) {
      const bool inner = x >= rim && y >= rim && x < grey.width() - rim && y < grey.height() - rim;
      if (!inner && std::isfinite(grey.at(x, y))) values.push_back(grey.at(x, y));
    }
  return values;
}

/// Where values part best in two (Otsu 1979), and how much of their variance that explains.
struct Parting {
  float at = 0;
  double explained = 0;
};
Parting best_parting(std::span<const float> values) {
  constexpr int kLevels = 256;
  std::array<double, kLevels> counts{};
  double all = 0, sum = 0, squares = 0;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    const int level = std::clamp(static_cast<int>(value + 0.5f), 0, kLevels - 1);
    ++counts[level];
    ++all;
    sum += level;
    squares += double(level) * level;
  }
  const double variance = squares / all - sum / all * (sum / all);
  Parting best;
  double below = 0, sum_below = 0;
  for (int level = 0; level + 1 < kLevels; ++level) {
    below += counts[level];
    sum_below += counts[level] * level;
    if (below == 0 || below == all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below / all * (1 - below / all) * apart * apart;
    if (between > best.explained * variance) best = {static_cast<float>(level) + 0.5f, between / variance};
  }
  return best;
}

}  // namespace

PlainBackground plain_background(const ShapeView& whole) {
  std::vector<double> rim = rim_of(whole.grey);
  if (rim.empty()) return {};
  PlainBackground background{.found = true, .level = static_cast<float>(median(rim))};
  std::vector<float> off(whole.grey.data(), whole.grey.data() + whole.grey.size());
  for (float& value : off) value = std::abs(value - background.level);
  const Parting parting = best_parting(off);
  background.spread = std::max(kLeastSpread, kSure * parting.at);
  const auto share = [&](const auto& values) {
    const auto like = std::count_if(values.begin(), values.end(), [&](auto grey) {
      return std::isfinite(grey) && is_like(background, static_cast<float>(grey));
    });
    return static_cast<double>(like) / static_cast<double>(values.size());
  };
  const std::vector<float> all(whole.grey.data(), whole.grey.data() + whole.grey.size());
  const double object = 1 - share(all);
  background.found = parting.explained >= kApart && background.spread <= kMostSpread && share(rim) >= kMostOfRim &&
                     object >= kLeastObject && object <= kMostObject;
  return background;
}

void mark_background(const PlainBackground& background, ShapeView& view) {
  const int width = view.grey.width(), height = view.grey.height();
  view.outline = ImageU8(width, height, 1, static_cast<std::uint8_t>(Outline::kObject));
  std::vector<std::pair<int, int>> reached;
  const auto reach = [&](int x, int y) {
    std::uint8_t& mark = view.outline.at(x, y);
    if (mark != static_cast<std::uint8_t>(Outline::kUnknown)) return;
    mark = static_cast<std::uint8_t>(Outline::kBackground);
    reached.emplace_back(x, y);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (!std::isfinite(view.grey.at(x, y)) || is_like(background, view.grey.at(x, y)))
        view.outline.at(x, y) = static_cast<std::uint8_t>(Outline::kUnknown);
  for (int x = 0; x < width; ++x) reach(x, 0), reach(x, height - 1);
  for (int y = 0; y < height; ++y) reach(0, y), reach(width - 1, y);
  while (!reached.empty()) {
    const auto [x, y] = reached.back();
    reached.pop_back();
    if (x > 0) reach(x - 1, y);
    if (y > 0) reach(x, y - 1);
    if (x + 1 < width) reach(x + 1, y);
    if (y + 1 < height) reach(x, y + 1);
  }
}

}  // namespace sheen
