// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_interpolation.h"

#include <cmath>

namespace sheen {
namespace {

constexpr int kFirstChoice = 5;  // views; fewer say nothing about how fast a ring varies
constexpr double kChoiceGrowth = 1.4, kLateChoiceGrowth = 2;
constexpr double kLateChoice = 32;  // images; a choice costs the cube of its views, and changes less and less
constexpr double kGoldenRatio = 0.6180339887498949;

}  // namespace

/// Choices come as soon as there can be one, and then at numbers of images that grow by a factor; rings of differing
/// phase take others of them, so that every image has its share.
int RingInterpolation::due_after(int images) const {
  if (images < kFirstChoice) return kFirstChoice;
  const double phase = phase_ * kGoldenRatio - std::floor(phase_ * kGoldenRatio);  // 0..1
  double due = kFirstChoice * std::pow(kChoiceGrowth, phase);
  while (std::ceil(due) <= images) due *= due < kLateChoice ? kChoiceGrowth : kLateChoiceGrowth;
  return static_cast<int>(std::ceil(due));
}

void RingInterpolation::choose(const ViewInterpolation& interpolation, int images) {
  due_ = due_after(images);
  chosen_ = interpolation;
}

bool RingInterpolation::can_choose(int views) {
  return views >= kFirstChoice;
}

/// Empty without a shared reflection.
Eigen::VectorXf RingInterpolation::drift_of(const ViewSet& views, const Eigen::Vector3f& normal) const {
  Eigen::VectorXf drift(reflection_ ? views.count() : 0);
  for (Eigen::Index j = 0; j < drift.size(); ++j) drift[j] = reflection_->at(views.directions()[j], normal);
  return drift;
}

InterpolationErrors RingInterpolation::errors(const ViewSet& views, const Eigen::MatrixXf& coefficients,
                                              const Eigen::Vector3f& normal) const {
  return interpolation_errors(views.direction_matrix(), coefficients, views.reliability(), drift_of(views, normal));
}

ViewInterpolant RingInterpolation::krige(const ViewSet& views, const Eigen::MatrixXf& coefficients,
                                         const Eigen::Vector3f& normal) const {
  return sheen::krige(views.direction_matrix(), coefficients, views.reliability(), chosen_.kernel,
                      chosen_.drift ? drift_of(views, normal) : Eigen::VectorXf());
}

Eigen::VectorXf RingInterpolation::at(const ViewInterpolant& interpolant, const ViewSet& views,
                                      const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const {
  Eigen::VectorXf h = interpolate(interpolant, views.direction_matrix(), chosen_.kernel, direction);
  if (interpolant.drift.size() > 0) h += reflection_->at(direction, normal) * interpolant.drift;
  return h;
}

}  // namespace sheen
