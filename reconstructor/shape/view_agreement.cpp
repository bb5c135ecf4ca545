// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/view_agreement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/window_matcher.h"

namespace sheen {
namespace {

constexpr double kFarthest = 35 * kDegree;
constexpr std::size_t kPartners = 12;
constexpr double kWindows = 60;            // per view, about
constexpr float kNearer = 0.98f;           // of a depth: what another view has before it hides it
constexpr float kAlike = 0.4f;             // cost up to which a window shows the same, ...
constexpr float kSamePlace_px = 2;         // ... so near the place where the poses have it
constexpr int kReach = 6;                  // pixels to either side in which a place is looked for
constexpr std::size_t kFewestTelling = 8;  // windows, for a median

struct Window {
  int x, y;
  SurfacePiece piece;
};

/// Places of the surface that a view has found, spread over it.
std::vector<Window> windows_of(const DepthMap& map) {
  std::size_t known = 0;
  for (int y = 0; y < map.depth.height(); ++y)
    for (int x = 0; x < map.depth.width(); ++x) known += map.depth.at(x, y) > 0 ? 1 : 0;
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(known) / kWindows)));
  std::vector<Window> windows;
  for (int y = step / 2; y < map.depth.height(); y += step)
    for (int x = step / 2; x < map.depth.width(); x += step)
      if (map.depth.at(x, y) > 0)
        windows.push_back({x, y, {map.depth.at(x, y), Eigen::Map<const Eigen::Vector3f>(map.normal.pixel(x, y))}});
  return windows;
}

bool hidden(const DepthMap& map, const Eigen::Vector2f& pixel, float depth) {
  const float before = map.depth.at(static_cast<int>(pixel.x() + 0.5f), static_cast<int>(pixel.y() + 0.5f));
  return before > 0 && before < kNearer * depth;
}

/// From where the poses have a window to where another view shows it: the place of least cost, to a part of a pixel.
/// Empty where it shows it nowhere near, or at the rim of what was searched.
std::optional<Eigen::Vector2f> way_aside(const WindowMatcher& matcher, std::size_t other, const SurfacePiece& piece) {
  constexpr int kSide = 2 * kReach + 1;
  std::array<float, kSide * kSide> costs;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      costs[u + kSide * v] =
          matcher.cost_aside(other, piece, {static_cast<float>(u - kReach), static_cast<float>(v - kReach)});
  const auto best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const int u = best % kSide, v = best / kSide;
  if (costs[best] > kAlike || u == 0 || v == 0 || u + 1 == kSide || v + 1 == kSide) return std::nullopt;
  const auto vertex = [&](int step) {
    const float before = costs[best - step], after = costs[best + step], bend = before - 2 * costs[best] + after;
    return bend > 0 ? 0.5f * (before - after) / bend : 0.0f;
  };
  return Eigen::Vector2f(static_cast<float>(u - kReach) + vertex(1), static_cast<float>(v - kReach) + vertex(kSide));
}

PairAgreement agreement(const ShapeView& view, const std::vector<Window>& windows, const ShapeView& other,
                        const DepthMap& map_of_other) {
  WindowMatcher matcher(view, {&other});
  const Rigid3 other_from_view = other.camera.camera_from_object * view.camera.camera_from_object.inverse();
  PairAgreement pair;
  std::vector<double> across;
  for (const Window& window : windows) {
    if (!matcher.take(window.x, window.y)) continue;
    const Eigen::Vector3f ray = matcher.ray(static_cast<float>(window.x), static_cast<float>(window.y));
    const Eigen::Vector3f there = (other_from_view * (window.piece.depth * ray).cast<double>()).cast<float>();
    const Eigen::Vector2f pixel = matcher.place_in(0, window.piece.depth);
    constexpr float kRim = 8;
    if (!(pixel.x() >= kRim && pixel.y() >= kRim && pixel.x() < static_cast<float>(other.grey.width()) - kRim &&
          pixel.y() < static_cast<float>(other.grey.height()) - kRim) ||
        hidden(map_of_other, pixel, there.z()))
      continue;
    ++pair.windows;
    const auto aside = way_aside(matcher, 0, window.piece);
    if (!aside) continue;
    if (aside->norm() <= kSamePlace_px) ++pair.alike;
    const Eigen::Vector2f with_depth = matcher.place_in(0, 1.02f * window.piece.depth) - pixel;
    if (!(with_depth.norm() > 0)) continue;
    const Eigen::Vector2f along = with_depth.normalized();
    across.push_back(along.x() * aside->y() - along.y() * aside->x());
  }
  // Signed: an error of a pose moves all windows alike, highlights go one way here and another there.
  if (across.size() >= kFewestTelling) pair.across_px = std::abs(median(across));
  return pair;
}

/// Numbers of a view's partners, and the angles to them.
using Partners = std::vector<std::pair<double, std::size_t>>;

/// Evenly over all angles up to the farthest.
Partners partners_of(std::size_t view, const std::vector<Eigen::Vector3d>& directions) {
  Partners near;
  for (std::size_t j = 0; j < directions.size(); ++j) {
    const double angle = std::acos(std::clamp(directions[view].dot(directions[j]), -1.0, 1.0));
    if (j != view && angle <= kFarthest) near.emplace_back(angle, j);
  }
  std::sort(near.begin(), near.end());
  if (near.size() <= kPartners) return near;
  Partners spread;
  for (std::size_t k = 0; k < kPartners; ++k) spread.push_back(near[k * near.size() / kPartners]);
  return spread;
}

}  // namespace

std::vector<PairAgreement> agreement_of_pairs(std::span<const ShapeView> views, std::span<const DepthMap> depths,
                                              const Eigen::Vector3d& middle) {
  std::vector<Eigen::Vector3d> directions;
  for (const ShapeView& view : views)
    directions.push_back((camera_centre(view.camera.camera_from_object) - middle).normalized());
  std::vector<std::vector<PairAgreement>> of_views(views.size());
  in_parallel(views.size(), [&](std::size_t i) {
    const std::vector<Window> windows = windows_of(depths[i]);
    for (const auto& [angle, j] : partners_of(i, directions)) {
      PairAgreement pair = agreement(views[i], windows, views[j], depths[j]);
      pair.of = i;
      pair.in = j;
      pair.angle = angle;
      if (pair.windows > 0) of_views[i].push_back(pair);
    }
  });
  std::vector<PairAgreement> pairs;
  for (const std::vector<PairAgreement>& of_view : of_views) pairs.insert(pairs.end(), of_view.begin(), of_view.end());
  return pairs;
}

std::optional<Split> best_split(std::span<const PairAgreement> pairs, std::size_t views) {
  constexpr int kAngles = 4;
  constexpr double kFewestAcross = 6;
  struct Mean {
    double sum = 0, count = 0;
    double value() const { return sum / std::max(1.0, count); }
  };
  std::optional<Split> best;
  double best_apart = 0;
  for (std::size_t after = 1; after + 2 < views; ++after) {
    std::array<Mean, kAngles> within, across;
    for (const PairAgreement& pair : pairs) {
      const int angle = std::min(kAngles - 1, static_cast<int>(kAngles * pair.angle / kFarthest));
      Mean& mean = ((pair.of <= after) == (pair.in <= after) ? within : across)[angle];
      mean.sum += pair.share();
      mean.count += 1;
    }
    double weights = 0, of_within = 0, of_across = 0;
    for (int angle = 0; angle < kAngles; ++angle) {
      const double weight =
          within[angle].count * across[angle].count / std::max(1.0, within[angle].count + across[angle].count);
      weights += weight;
      of_within += weight * within[angle].value();
      of_across += weight * across[angle].value();
    }
    if (weights < kFewestAcross / 2) continue;
    const double apart = (of_within - of_across) / weights * std::sqrt(weights);
    if (apart > best_apart) best_apart = apart, best = Split{after, of_within / weights, of_across / weights};
  }
  return best;
}

}  // namespace sheen
