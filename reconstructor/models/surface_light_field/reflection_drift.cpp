// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/reflection_drift.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace sheen {
namespace {

constexpr int kRounds = 4;
constexpr Eigen::Index kFewestViews = 4;
constexpr std::size_t kFewestRings = 20;
constexpr float kHighestLevel = 1.2f;     // what is imputed from little can run away
constexpr double kSmoothness = 1e-4;      // of the mean eigenvalue, growing with the degree as the Laplacian's square
constexpr float kHighestSensitivity = 4;  // of the mean level
constexpr float kDrawnToMeanLevel = 0.5f;

Eigen::Vector3f mirrored(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) {
  return 2 * normal.dot(direction) * normal - direction;
}

/// A ring with everything centred on its weighted means.
struct Centred {
  Eigen::MatrixXf harmonics;  ///< kHarmonics x views
  Eigen::Matrix3Xf levels;
  Eigen::VectorXf weight;
  Eigen::Vector3f mean;
  Eigen::Vector3f sensitivity;
};

Centred centred(const RingLevels& ring) {
  Centred out;
  out.weight = ring.reliability;
  out.levels = ring.levels.cwiseMax(0).cwiseMin(kHighestLevel);
  out.harmonics.resize(kHarmonics, ring.directions.cols());
  for (Eigen::Index j = 0; j < ring.directions.cols(); ++j)
    out.harmonics.col(j) = spherical_harmonics(mirrored(ring.directions.col(j), ring.normal).normalized());
  const Eigen::VectorXf share = out.weight / out.weight.sum();
  out.mean = out.levels * share;
  out.levels.colwise() -= out.mean;
  const Eigen::VectorXf mean_harmonics = out.harmonics * share;
  out.harmonics.colwise() -= mean_harmonics;
  out.sensitivity = out.mean;
  return out;
}

using Normal = Eigen::Matrix<double, kHarmonics, kHarmonics>;

Harmonics solve_light(const std::vector<Centred>& rings) {
  Normal normal = Normal::Zero();
  Eigen::Matrix<double, kHarmonics, 1> right = Eigen::Matrix<double, kHarmonics, 1>::Zero();
  for (const Centred& ring : rings) {
    const Eigen::MatrixXf weighted = ring.harmonics * ring.weight.asDiagonal();
    const Eigen::MatrixXf outer = weighted * ring.harmonics.transpose();
    normal += (ring.sensitivity.squaredNorm() * outer).cast<double>();
    right += (weighted * (ring.levels.transpose() * ring.sensitivity)).cast<double>();
  }
  const double mean_eigenvalue = normal.trace() / kHarmonics;
  for (int l = 0; l <= kHarmonicDegree; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i)
      normal(i, i) += kSmoothness * mean_eigenvalue * (1 + l * l * (l + 1.0) * (l + 1.0) / 10);
  return normal.llt().solve(right).cast<float>();
}

void solve_sensitivities(const Harmonics& light, std::vector<Centred>& rings) {
  for (Centred& ring : rings) {
    const Eigen::VectorXf f = ring.harmonics.transpose() * light;
    const Eigen::VectorXf weighted = ring.weight.cwiseProduct(f);
    const float power = std::max(weighted.dot(f), 1e-6f);
    for (int c = 0; c < 3; ++c) {
      const float free = std::clamp(ring.levels.row(c).dot(weighted) / power, 0.0f, kHighestSensitivity * ring.mean[c]);
      ring.sensitivity[c] = (1 - kDrawnToMeanLevel) * free + kDrawnToMeanLevel * ring.mean[c];
    }
  }
}

}  // namespace

float ReflectionDrift::at(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const {
  return coefficients.dot(spherical_harmonics(mirrored(direction, normal).normalized()));
}

std::shared_ptr<const ReflectionDrift> estimate_reflection_drift(std::span<const RingLevels> rings) {
  std::vector<Centred> used;
  for (const RingLevels& ring : rings)
    if (ring.directions.cols() >= kFewestViews) used.push_back(centred(ring));
  if (used.size() < kFewestRings) return nullptr;
  auto drift = std::make_shared<ReflectionDrift>();
  for (int round = 0; round < kRounds; ++round) {
    drift->coefficients = solve_light(used);
    if (!drift->coefficients.allFinite() || drift->coefficients.isZero()) return nullptr;
    solve_sensitivities(drift->coefficients, used);
  }
  return drift;
}

}  // namespace sheen
