// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/reflection_fit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace sheen {
namespace {

constexpr int kRounds = 4;
constexpr Eigen::Index kFewestViews = 4;
constexpr std::size_t kFewestPatches = 20;
constexpr float kHighestLevel = 1.2f;     // what is imputed from little can run away
constexpr double kSmoothness = 1e-4;      // of the mean eigenvalue, growing with the degree as the Laplacian's square
constexpr float kHighestSensitivity = 4;  // of the mean level
constexpr float kDrawnToMeanLevel = 0.5f;

constexpr std::size_t kBlock = 16;  // patches whose equations are summed on one thread

using Normal = Eigen::Matrix<double, kHarmonics, kHarmonics>;

}  // namespace

/// A patch with everything centred on its weighted means.
struct ReflectionFit::Centred {
  explicit Centred(const PatchLevels& patch);

  Eigen::MatrixXf harmonics;  ///< kHarmonics x views
  Eigen::Matrix3Xf levels;
  Eigen::VectorXf weight;
  Eigen::Vector3f mean;
  Eigen::Vector3f sensitivity;
};

ReflectionFit::Centred::Centred(const PatchLevels& patch)
    : harmonics(kHarmonics, patch.directions.cols()),
      levels(patch.levels.cwiseMax(0).cwiseMin(kHighestLevel)),
      weight(patch.reliability) {
  for (Eigen::Index j = 0; j < patch.directions.cols(); ++j)
    harmonics.col(j) = spherical_harmonics(mirrored(patch.directions.col(j), patch.normal));
  const Eigen::VectorXf fraction = weight / weight.sum();
  mean = levels * fraction;
  levels.colwise() -= mean;
  const Eigen::VectorXf mean_harmonics = harmonics * fraction;
  harmonics.colwise() -= mean_harmonics;
  sensitivity = mean;
}

ReflectionFit::ReflectionFit(std::span<const PatchLevels> patches) {
  for (const PatchLevels& patch : patches)
    if (patch.directions.cols() >= kFewestViews) patches_.emplace_back(patch);
  if (patches_.size() < kFewestPatches) return;
  drift_ = std::make_shared<ReflectionDrift>();
  rounds_left_ = kRounds;
}

ReflectionFit::~ReflectionFit() = default;
ReflectionFit::ReflectionFit(ReflectionFit&&) noexcept = default;
ReflectionFit& ReflectionFit::operator=(ReflectionFit&&) noexcept = default;

void ReflectionFit::solve_light() {
  struct Equations {
    Normal normal = Normal::Zero();  ///< its lower half
    Eigen::Matrix<double, kHarmonics, 1> right = Eigen::Matrix<double, kHarmonics, 1>::Zero();
  };
  // Blocks of fixed size, summed in their order: the same bits on any number of threads.
  std::vector<Equations> blocks((patches_.size() + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    for (std::size_t i = b * kBlock; i < std::min((b + 1) * kBlock, patches_.size()); ++i) {
      const Centred& patch = patches_[i];
      const Eigen::MatrixXf rooted =
          patch.sensitivity.norm() * (patch.harmonics * patch.weight.cwiseSqrt().asDiagonal());
      Eigen::Matrix<float, kHarmonics, kHarmonics> outer = Eigen::Matrix<float, kHarmonics, kHarmonics>::Zero();
      outer.selfadjointView<Eigen::Lower>().rankUpdate(rooted);
      blocks[b].normal += outer.cast<double>();
      const Eigen::VectorXf wanted = patch.weight.cwiseProduct(patch.levels.transpose() * patch.sensitivity);
      blocks[b].right += (patch.harmonics * wanted).cast<double>();
    }
  });
  Equations sum;
  for (const Equations& block : blocks) {
    sum.normal += block.normal;
    sum.right += block.right;
  }
  const double mean_eigenvalue = sum.normal.trace() / kHarmonics;
  for (int l = 0; l <= kHarmonicDegree; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i)
      sum.normal(i, i) += kSmoothness * mean_eigenvalue * (1 + l * l * (l + 1.0) * (l + 1.0) / 10);
  drift_->coefficients = sum.normal.llt().solve(sum.right).cast<float>();
}

void ReflectionFit::solve_sensitivities() {
  for (Centred& patch : patches_) {
    const Eigen::VectorXf f = patch.harmonics.transpose() * drift_->coefficients;
    const Eigen::VectorXf weighted = patch.weight.cwiseProduct(f);
    const float power = std::max(weighted.dot(f), 1e-6f);
    for (int c = 0; c < 3; ++c) {
      const float free =
          std::clamp(patch.levels.row(c).dot(weighted) / power, 0.0f, kHighestSensitivity * patch.mean[c]);
      patch.sensitivity[c] = (1 - kDrawnToMeanLevel) * free + kDrawnToMeanLevel * patch.mean[c];
    }
  }
}

bool ReflectionFit::step() {
  if (rounds_left_ == 0) return true;
  solve_light();
  if (!drift_->coefficients.allFinite() || drift_->coefficients.isZero()) {
    drift_ = nullptr;
    rounds_left_ = 0;
    return true;
  }
  if (--rounds_left_ == 0) return true;
  solve_sensitivities();
  return false;
}

std::shared_ptr<const ReflectionDrift> estimate_reflection_drift(std::span<const PatchLevels> patches) {
  ReflectionFit fit(patches);
  while (!fit.step()) {
  }
  return fit.result();
}

}  // namespace sheen
