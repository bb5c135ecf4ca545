// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/snapshot.h"
#include "reconstructor/numerics/ring_factor.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

struct RingModelOptions {
  RingFactorOptions factor;
  int max_views = 64;            ///< directions kept a ring; beyond it the two nearest ones become one
  double min_visible = 0.1;      ///< share of a ring's samples that an image must show
  double residual_memory = 0.7;  ///< of the exponential filter on the projection error (000 sec. 3.3)
};

/// Errors of predicting each view from the others, a kernel of kViewKernels.
using KernelErrors = std::array<double, kViewKernels.size()>;

/// The surface light field round one vertex as it grows: the online SVD of what was seen and from where.
class RingModel {
 public:
  RingModel(int samples, const RingModelOptions& options)
      : options_(options), factor_(3 * samples, options.factor), shown_(samples, 0) {}

  struct Absorbed {
    bool used = false;           ///< false: too little of the ring is visible
    double energy = 0;           ///< ||c||^2 over what is visible
    double residual_energy = 0;  ///< ||p||^2 over what is visible
    bool wants_kernel = false;   ///< enough views have come to choose the kernel anew
  };

  /// Folds in what one image shows. `column`: encoded values of all rows; rows of samples that are not `visible` are
  /// overwritten by what is imputed. `reliability` in (0, 1] weighs the image in the interpolation between views.
  Absorbed absorb(Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& direction,
                  float cosine, float reliability);

  KernelErrors kernel_errors() const;
  void set_kernel(const ViewKernel& kernel);
  const ViewKernel& kernel() const { return kernel_; }

  int rank() const { return factor_.rank(); }
  int views() const { return factor_.views(); }
  const RingFactor& factor() const { return factor_; }
  std::size_t bytes() const;

  /// The ring as it now stands, with a guess where no image showed it (`fill_unseen_samples`); the same object until
  /// something changes. `resolution`: of the ring's triangles, in its order.
  std::shared_ptr<const RingSnapshot> snapshot(const Eigen::Matrix3f& frame, std::span<const int> resolution);

 private:
  void fill_hidden(Eigen::VectorXf& column, std::span<const std::uint8_t> visible);
  void keep_view(const Eigen::Vector3f& direction, float reliability);
  void merge_nearest_views();

  RingModelOptions options_;
  RingFactor factor_;
  std::vector<std::uint16_t> shown_;  ///< a sample: images that showed it, as far as the type counts
  bool all_seen_ = false;
  std::vector<Eigen::Vector3f> directions_;
  std::vector<float> reliability_;
  std::vector<int> images_;  ///< that each kept view stands for
  ViewKernel kernel_;
  int kernel_chosen_at_ = 0;  ///< images folded in when the kernel was last chosen
  int images_folded_ = 0;
  float residual_ = 1;
  float noise_ = 1e-4f;  ///< variance of a row that the basis does not explain
  float best_cosine_ = 0;
  std::shared_ptr<const RingSnapshot> snapshot_;
};

}  // namespace sheen
