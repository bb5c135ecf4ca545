// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/light_set.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/errors.h"
#include "reconstructor/radiance/light_refusal.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kNearest = 6;   // lights that are tried as neighbours
constexpr double kSpreadCost = 1e-3;  // of the squared distances to the neighbours: prefers near ones

/// The weights of these lights that sum to 1 and minimise the distance to `place`, with the cost of a spread; empty
/// where one of them is negative.
Eigen::VectorXd simplex_weights(const Eigen::Matrix3Xd& lights, const Vector3d& place) {
  const Eigen::Index n = lights.cols();
  const Eigen::Matrix3Xd off = lights.colwise() - place;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 1, n + 1);
  system.topLeftCorner(n, n) = off.transpose() * off + 1e-12 * off.squaredNorm() * Eigen::MatrixXd::Identity(n, n);
  system.col(n).head(n).setOnes();
  system.row(n).head(n).setOnes();
  Eigen::VectorXd right(n + 1);
  right.head(n) = -0.5 * kSpreadCost * off.colwise().squaredNorm().transpose();
  right[n] = 1;
  const Eigen::VectorXd weights = system.fullPivLu().solve(right).head(n);
  if (!weights.allFinite() || weights.minCoeff() < -1e-9 || std::abs(weights.sum() - 1) > 1e-6) return {};
  return weights.cwiseMax(0);
}

}  // namespace

Lamp LightSet::lamp(const Vector3d& place) const {
  const bool point = kind == LightKind::kPoint && size() > 0;
  return {kind, place.cast<float>(), point ? static_cast<float>(places.colwise().squaredNorm().mean()) : 1};
}

Vector3d LightSet::place_of(const LightState& light) const {
  if (!light_refusal(light, kind).empty())
    throw ConfigError(kind == LightKind::kDirectional
                          ? "this lumigraph was captured in directional light: give directions, not positions"
                          : "this lumigraph was captured in the light of near lamps: give positions, not directions");
  return kind == LightKind::kDirectional ? light.position.normalized() : light.position;
}

std::vector<std::pair<int, float>> LightSet::between(const Vector3d& place) const {
  std::vector<int> order(static_cast<std::size_t>(size()));
  std::iota(order.begin(), order.end(), 0);
  const auto distance = [&](int i) { return (places.col(i) - place).norm(); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return distance(a) < distance(b); });
  if (order.empty()) return {};
  if (order.size() == 1 || same_light_place(places.col(order[0]), place)) return {{order[0], 1.0f}};
  if (order.size() > kNearest) order.resize(kNearest);

  double best_cost = std::numeric_limits<double>::infinity();
  std::vector<std::pair<int, float>> best;
  const auto try_lights = [&](const std::vector<int>& chosen) {
    Eigen::Matrix3Xd lights(3, static_cast<Eigen::Index>(chosen.size()));
    for (std::size_t c = 0; c < chosen.size(); ++c) lights.col(static_cast<Eigen::Index>(c)) = places.col(chosen[c]);
    const Eigen::VectorXd weights = simplex_weights(lights, place);
    if (weights.size() == 0) return;
    const double cost = (lights * weights - place).squaredNorm() +
                        kSpreadCost * weights.dot((lights.colwise() - place).colwise().squaredNorm().transpose());
    if (cost >= best_cost * (1 - 1e-9)) return;
    best_cost = cost;
    best.clear();
    for (std::size_t c = 0; c < chosen.size(); ++c)
      best.emplace_back(chosen[c], static_cast<float>(weights[static_cast<Eigen::Index>(c)]));
  };
  const std::size_t n = order.size();
  for (std::size_t i = 0; i < n; ++i) {
    try_lights({order[i]});
    for (std::size_t j = i + 1; j < n; ++j) {
      try_lights({order[i], order[j]});
      for (std::size_t k = j + 1; k < n; ++k) try_lights({order[i], order[j], order[k]});
    }
  }
  return best;
}

}  // namespace sheen
