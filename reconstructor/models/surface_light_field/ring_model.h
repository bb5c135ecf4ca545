// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/reflection_drift.h"
#include "reconstructor/models/surface_light_field/ring_interpolation.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"
#include "reconstructor/models/surface_light_field/view_set.h"
#include "reconstructor/numerics/ring_factor.h"

namespace sheen {

struct RingModelOptions {
  RingFactorOptions factor;
  int max_views = 96;            ///< directions kept per ring; beyond it the two nearest ones become one
  double min_visible = 0.1;      ///< fraction of a ring's samples that an image must show
  double repeat_angle = 0.0175;  ///< rad from a kept view within which an image may be a repetition of it; 0 = none is
  ViewInterpolationOptions interpolation;
  double residual_memory = 0.7;  ///< of the exponential filter on the projection error (000 sec. 3.3)
};

/// As the factor of a ring takes them: three channels, and the noise of a camera.
RingFactorOptions ring_factor_options(RingFactorOptions options);

/// Weight of an image in a ring's factor: what it does not show is a guess that only repeats the basis, so it counts
/// for less than its fraction (docs/decisions/missing_samples.md). The paper's imputation has no weights.
double image_weight(const RingFactorOptions& options, double share_shown);

/// The surface light field round one vertex as it grows: the online SVD of what was seen (RingFactor), from where
/// (ViewSet), and what lies between (RingInterpolation). The three know nothing of each other; views have the same
/// numbers in factor and set.
class RingModel {
 public:
  /// `phase`: rings of differing phase fold their columns and choose their interpolation at different images, which
  /// spreads the work.
  RingModel(int samples, const RingModelOptions& options, unsigned phase = 0);

  struct Absorbed {
    bool used = false;                 ///< false: too little of the ring is visible
    bool wants_interpolation = false;  ///< enough images have come to choose it again
    double energy = 0;                 ///< of the columns that this one's coming folded: ||c||^2 over what they show
    double residual_energy = 0;        ///< of the same: ||p||^2, what the ring's basis did not predict of them
  };

  /// Ingests what one image shows. `column`: encoded values of all rows, which other rings may hold too.
  /// `reliability` in (0, 1] weighs the image in the interpolation between views.
  Absorbed absorb(std::vector<SharedRows<float>> column, std::span<const std::uint8_t> visible,
                  const Eigen::Vector3f& direction, float cosine, float reliability);

  void fold_pending();  ///< the images that wait to be folded

  /// Takes out again what an image gave: the arguments are those with which it was absorbed; values of samples that are
  /// not `visible` mean nothing, here and below. Exact for the view itself; what the image left in the others (samples
  /// that were imputed with its help, the filtered residual) stays.
  void withdraw(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& direction);

  /// Cosine of the angle between a direction and the nearest kept view's; -1 when there is none.
  float nearest_cosine(const Eigen::Vector3f& direction) const;
  /// Whether an image from there is near enough to a kept view to be a repetition of it.
  bool may_repeat(const Eigen::Vector3f& direction) const;
  /// Whether a column from there is also what that view showed, as closely as the basis explains any image: absorbing
  /// it would add nothing. Looks at an eighth of the samples; every sample that it looks at must have been shown
  /// before.
  bool repeats(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
               const Eigen::Vector3f& direction) const;

  /// Lets go of terms beyond lower limits (RingFactor::limit); they hold from now on.
  void limit_terms(int max_rank, int internal_rank, int block);

  /// How the ring as it stands, before an image is absorbed, predicts the image: over the values that the image shows
  /// and earlier ones did, encoded.
  struct Prediction {
    double squared_error = 0;
    std::size_t values = 0;
  };
  Prediction predict(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                     const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const;

  bool can_choose_interpolation() const;  ///< there are views enough to say how fast the ring varies
  /// `normal`: of the vertex. Errors with the drift are infinite while there is none, and with too few views.
  InterpolationErrors interpolation_errors(const Eigen::Vector3f& normal) const;
  void set_interpolation(const ViewInterpolation& interpolation);
  const ViewInterpolation& interpolation() const { return interpolation_.chosen(); }
  /// What all rings share; a ring takes part in it by its levels.
  void set_reflection(std::shared_ptr<const ReflectionDrift> reflection);
  RingLevels levels(const Eigen::Vector3f& normal) const;

  int rank() const { return factor_.displayed_rank(); }
  int views() const { return factor_.views(); }
  const RingFactor& factor() const { return factor_; }
  std::size_t bytes() const;
  std::size_t snapshot_bytes() const;  ///< of `snapshot`, whether it is there or not
  /// Upper bounds of these for a ring of so many samples, whatever images come; of many rings, by their mean.
  static double largest_bytes(double samples, const RingModelOptions& options);
  static double largest_snapshot_bytes(double samples, const RingModelOptions& options);

  /// The ring as it now stands, columns that wait to be folded included, with a guess where no image showed it
  /// (`fill_unseen_samples`); the same object until something changes. Taking it changes nothing. `resolution`: of the
  /// ring's triangles, in its order.
  std::shared_ptr<const RingSnapshot> snapshot(const Eigen::Matrix3f& frame, std::span<const int> resolution);

 private:
  std::shared_ptr<const RingSnapshot> settled_snapshot(const Eigen::Matrix3f& frame,
                                                       std::span<const int> resolution) const;
  Eigen::MatrixXf with_pending(const Eigen::Ref<const Eigen::MatrixXf>& folded) const;
  Eigen::MatrixXf known_coefficients() const;
  void follow(const RingFactor::Reports& reports, Absorbed& result);
  bool shows_enough(std::size_t shown, std::size_t samples) const;
  void thin_views();

  RingModelOptions options_;
  RingFactor factor_;
  ViewSet views_;
  RingInterpolation interpolation_;
  std::vector<std::uint16_t> shown_;  ///< for each sample: images that showed it, as far as the type counts
  int images_ = 0;                    ///< ingested
  float residual_ = 1;
  float best_cosine_ = 0;
  std::shared_ptr<const RingSnapshot> snapshot_;
};

}  // namespace sheen
