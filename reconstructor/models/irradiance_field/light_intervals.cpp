// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/light_intervals.h"

#include <algorithm>
#include <cmath>

#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"

namespace sheen {
namespace {

constexpr std::size_t kFewestLights = 8;
constexpr double kFraction = 0.99;  // of the pixels, that an error is stated of: the rest are edges of shadows
constexpr double kLeastError = 1e-3;
constexpr double kRim = 0.5;            // more one-sided lights say nothing of growth
constexpr std::size_t kMostTried = 32;  // of which growth is measured
constexpr double kLeastGrowth = 0.25, kMostGrowth = 2;

/// Largest of a pixel's three differences, in grey levels, that `kFraction` of the pixels stay below.
double typical_largest(const ImageF& differences) {
  std::vector<float> largest(differences.size() / 3);
  for (std::size_t i = 0; i < largest.size(); ++i) {
    const float* pixel = differences.data() + 3 * i;
    largest[i] = std::max({std::abs(pixel[0]), std::abs(pixel[1]), std::abs(pixel[2])});
  }
  return static_cast<double>(quantile(largest, kFraction));
}

/// What surrounds a light.
struct Surroundings {
  std::vector<Eigen::Index> neighbours;
  Eigen::Vector3d offsets = Eigen::Vector3d::Zero();
  double lengths = 0;

  void add(Eigen::Index neighbour, const Eigen::Vector3d& offset) {
    neighbours.push_back(neighbour);
    offsets += offset;
    lengths += offset.norm();
  }
  double gap() const { return lengths / static_cast<double>(neighbours.size()); }
  double one_sided() const { return offsets.norm() / lengths; }  ///< 0 in the middle of others, near 1 beyond them
};

/// Weights with which the lights that stay show light i, less itself.
Eigen::VectorXf residual_without(const LitScene& scene, Eigen::Index i, const std::vector<Eigen::Index>& left_out) {
  std::vector<Eigen::Index> stay;
  for (Eigen::Index k = 0; k < scene.lights.cols(); ++k)
    if (k != i && std::find(left_out.begin(), left_out.end(), k) == left_out.end()) stay.push_back(k);
  const PointKriging fewer(scene.lights(Eigen::all, stay), scene.kernel);
  Eigen::VectorXf residual = Eigen::VectorXf::Zero(scene.lights.cols());
  residual(stay) = -fewer.weights(scene.lights.col(i));
  residual[i] = 1;
  return residual;
}

/// The power of an interval's width with which errors grow: the median over lights.
double growth(const LitScene& scene, const Relighting& relighting, const std::vector<Surroundings>& around,
              const std::vector<double>& errors) {
  std::vector<double> powers;
  const auto n = static_cast<std::size_t>(scene.lights.cols());
  const std::size_t step = std::max<std::size_t>(1, n / kMostTried);
  for (std::size_t i = 0; i < n; i += step) {
    if (around[i].neighbours.size() + kFewestLights > n || around[i].one_sided() > kRim) continue;
    const ImageF wider = relighting.encoded_picture(
        residual_without(scene, static_cast<Eigen::Index>(i), around[i].neighbours), in_parallel);
    powers.push_back(std::log2(std::max(typical_largest(wider), kLeastError) / std::max(errors[i], kLeastError)));
  }
  if (powers.empty()) return kLeastGrowth;
  return std::clamp(median(powers), kLeastGrowth, kMostGrowth);
}

double length_of(const LightState& a, const LightState& b) {
  return a.kind == LightKind::kDirectional ? std::acos(std::clamp(a.position.dot(b.position), -1.0, 1.0))
                                           : (a.position - b.position).norm();
}

}  // namespace

std::vector<std::array<Eigen::Index, 2>> neighbours(const Eigen::Matrix3Xd& points) {
  std::vector<std::array<Eigen::Index, 2>> pairs;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::Vector3d middle = (points.col(i) + points.col(j)) / 2;
      const double radius2 = (points.col(i) - middle).squaredNorm() * (1 - 1e-9);
      bool free = true;
      for (Eigen::Index k = 0; k < points.cols() && free; ++k)
        free = k == i || k == j || (points.col(k) - middle).squaredNorm() >= radius2;
      if (free) pairs.push_back({j, i});
    }
  return pairs;
}

std::optional<LightAdvice> judge_lights(const LitScene& scene, const PointKriging& kriging,
                                        const Relighting& relighting, double tolerance) {
  const Eigen::Index n = scene.lights.cols();
  if (n < static_cast<Eigen::Index>(kFewestLights)) return std::nullopt;
  const std::vector<std::array<Eigen::Index, 2>> pairs = neighbours(scene.lights);
  std::vector<Surroundings> around(static_cast<std::size_t>(n));
  for (const auto& [i, j] : pairs) {
    around[static_cast<std::size_t>(i)].add(j, scene.lights.col(j) - scene.lights.col(i));
    around[static_cast<std::size_t>(j)].add(i, scene.lights.col(i) - scene.lights.col(j));
  }
  std::vector<double> errors;
  for (Eigen::Index i = 0; i < n; ++i)
    errors.push_back(
        typical_largest(relighting.encoded_picture(kriging.leave_one_out().row(i).transpose(), in_parallel)));
  const double power = growth(scene, relighting, around, errors);
  // Of an interval at a light, half way.
  const auto error_at = [&](Eigen::Index light, double length) {
    const Surroundings& here = around[static_cast<std::size_t>(light)];
    return errors[static_cast<std::size_t>(light)] / (1 + here.one_sided()) *
           std::pow(length / (2 * here.gap()), power);
  };
  LightAdvice advice;
  for (const auto& [i, j] : pairs) {
    LightInterval interval{.from = {.kind = scene.kind, .position = scene.lights.col(i)},
                           .to = {.kind = scene.kind, .position = scene.lights.col(j)}};
    interval.length = length_of(interval.from, interval.to);
    const double chord = (scene.lights.col(i) - scene.lights.col(j)).norm();
    interval.error = std::max(kLeastError, (error_at(i, chord) + error_at(j, chord)) / 2);
    interval.required = interval.length * std::pow(tolerance / interval.error, 1 / power);
    advice.intervals.push_back(interval);
  }
  std::stable_sort(advice.intervals.begin(), advice.intervals.end(),
                   [](const LightInterval& a, const LightInterval& b) { return a.error > b.error; });
  const LightInterval& worst = advice.intervals.front();
  advice.next = worst.from;
  advice.next.position = (worst.from.position + worst.to.position) / 2;
  if (scene.kind == LightKind::kDirectional) advice.next.position.normalize();
  return advice;
}

}  // namespace sheen
