// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "reconstructor/numerics/view_kernel.h"

namespace sheen {

/// Kriging of coefficients over view directions, in its dual form: h(d) = mean + drift * f(d) + weights * k(d), with
/// k(d)_j = k(angle(d, d_j)) and f a known function of the direction, the external drift: what is left of the
/// coefficients when their best multiple of f is taken away is interpolated, and the multiple is what makes that so
/// (universal kriging). Without a drift it is ordinary kriging.
struct ViewInterpolant {
  Eigen::VectorXf mean;     ///< rank
  Eigen::MatrixXf weights;  ///< rank x views
  Eigen::VectorXf drift;    ///< rank; empty without a drift
  /// Sum over views of their reliability times the squared error of predicting each from the others (closed form).
  double leave_one_out = 0;
  /// Scale of the covariance, summed over terms: that error over what the kernel lets expect of it, the same sum of the
  /// variances of such predictions. 0 with one view.
  double sill = 0;
};

/// A drift as far as the views bear it out. Universal kriging is ordinary kriging plus `ViewInterpolant::drift` times
/// what ordinary kriging of the drift itself leaves of it, g = f(d) - mean - weights . k(d), and its variance is that
/// of ordinary kriging plus g^2 / power, in units of the sill. At the views themselves that is what their noise leaves
/// open, and all is believed. Beyond them the drift is extrapolated and it grows without bound: g fades as it does, and
/// with it all that is more than ordinary kriging, which returns to the views' mean by itself.
struct BelievedDrift {
  Eigen::VectorXf weights;  ///< per view: Z f; empty where nothing but the mean is believed
  float mean = 0;
  float power = 1;  ///< f^T Z f
  float known = 0;  ///< the largest g^2 / power at the views themselves: so far all is believed

  /// To take in place of f(d). `covariances`: k(d).
  float at(float drift_there, const Eigen::VectorXf& covariances) const;
};

/// With fewer views a drift explains too much.
inline constexpr int kFewestViewsWithDrift = 6;

/// directions: 3 x views, unit. coefficients: rank x views. reliability: per view, > 0; the nugget is divided by it.
/// drift: f of each view, or empty. No view gives an empty interpolant, one view a constant; a drift that does not vary
/// over the views is left out.
ViewInterpolant krige(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                      const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel,
                      const Eigen::VectorXf& drift = {});

/// What `krige`, `interpolate` and the believed drift give for one unit direction, at which the drift is `drift_there`,
/// without what other directions would need. No view gives zeros.
Eigen::VectorXf krige_at(const Eigen::Vector3f& direction, float drift_there, const Eigen::Matrix3Xf& directions,
                         const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                         const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel,
                         const Eigen::VectorXf& drift = {});

/// `krige` of several sets of coefficients of the same views: what costs the cube of their number is done once.
class ViewKriging {
 public:
  /// Arguments as of `krige`.
  ViewKriging(const Eigen::Matrix3Xf& directions, const Eigen::Ref<const Eigen::VectorXf>& reliability,
              const ViewKernel& kernel, const Eigen::VectorXf& drift = {});
  ViewKriging(ViewKriging&&) noexcept;
  ~ViewKriging();

  bool has_drift() const;                ///< the views are enough for one, and it varies over them
  BelievedDrift believed_drift() const;  ///< there must be one
  ViewInterpolant of(const Eigen::Ref<const Eigen::MatrixXf>& coefficients) const;

 private:
  struct System;
  std::unique_ptr<System> system_;  ///< null without views
};

/// `ViewInterpolant::leave_one_out` without the interpolant, from one factorization for both: the second is infinite
/// where the views are too few or the drift does not vary. angles: between the views' directions. In single precision,
/// exact to a few 1e-6 for coefficients of which no square overflows; in a third of the time.
struct LeaveOneOut {
  double ordinary = 0, with_drift = 0;
};
template <typename Scalar = double>
LeaveOneOut leave_one_out(const Eigen::MatrixXf& angles, const Eigen::Ref<const Eigen::MatrixXf>& coefficients,
                          const Eigen::Ref<const Eigen::VectorXf>& reliability, const ViewKernel& kernel,
                          const Eigen::VectorXf& drift);

/// Variance of what is seen from a unit direction, given the views, in units of the sill: 1 + nugget - k^T Q k + (1 -
/// 1^T Q k)^2 / (1^T Q 1), Q being the inverse of the covariance of the six nearest views (no more change it to speak
/// of). At least one view.
float prediction_variance(const Eigen::Matrix3Xf& directions, const ViewKernel& kernel,
                          const Eigen::Vector3f& direction);

/// h(d) of an interpolant without drift for a unit direction.
Eigen::VectorXf interpolate(const ViewInterpolant& interpolant, const Eigen::Matrix3Xf& directions,
                            const ViewKernel& kernel, const Eigen::Vector3f& direction);

}  // namespace sheen
