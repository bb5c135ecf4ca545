// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/capture/capture.h"
#include "reconstructor/models/surface_light_field/patch_set.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "reconstructor/numerics/missing_pca.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// All that the images show of one patch: the matrix that an online factorization sees a column at a time.
struct PatchMatrix {
  Eigen::MatrixXf columns;            ///< rows x n, encoded; 0 where not known
  KnownValues known;                  ///< rows x n
  Eigen::Matrix3Xf eyes;              ///< of the cameras, object frame
  Eigen::MatrixXf reliability;        ///< vertices of the patch x n
  std::vector<std::uint32_t> images;  ///< which image each column comes from, counted from 0

  int views() const { return static_cast<int>(columns.cols()); }
  /// Fraction of the patch's values that an image shows.
  double fraction(int view) const { return known.col(view).cast<double>().mean(); }
  /// Of each view, as the online factorization weighs it.
  std::vector<double> weights() const;
};

/// The online factorization of a patch that sees its columns in this order.
OnlineSvd online_factor(const PatchMatrix& patch, const OnlineSvdOptions& options, std::span<const int> order);

/// How each patch is factorized when all its columns are there.
struct BatchFactorization {
  int rank = 6;           ///< terms kept
  int imputing_rank = 0;  ///< terms that impute what is missing; fewer than `rank` count as `rank`
  MissingPcaOptions missing;
  /// With these, the noise of a patch is what they measure of it online. Without, the most probable one: with as many
  /// terms as images it would be none.
  std::optional<OnlineSvdOptions> measures_noise;

  /// What a batch system takes the time for.
  static BatchFactorization quick(int rank) {
    return {.rank = rank, .missing = {.max_iterations = 20, .convergence = 5e-4}, .measures_noise = {}};
  }
  /// What the online factorization is measured against: the same imputation with as many terms as it has inside and the
  /// same noise, until it changes no more.
  static BatchFactorization reference(const OnlineSvdOptions& online) {
    return {.rank = online.max_rank,
            .imputing_rank = online.terms_kept(),
            .missing = {.max_iterations = 300, .convergence = 1e-4},
            .measures_noise = online};
  }
};

/// The surface light field as batch systems build it (Chen et al. 2002, which the paper calls OpenLF): every column of
/// every patch is kept until the last image, then each patch is factorized at once, with missing values by expectation
/// maximisation. Seeing, resampling, the weight of an image in a patch, interpolation between views and rendering are
/// those of the online light field, so that what differs is the factorization.
class BatchLightField {
 public:
  /// `every`: only patches 0, every, 2 every, ... are kept, to try things on a part of them.
  BatchLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options, std::size_t every = 1);

  /// Resamples an image and keeps its columns. Exposures must be on one level. Images without a pose are not for it.
  void add(const Capture& capture);
  std::size_t bytes() const;  ///< of the columns kept
  std::size_t images() const { return images_; }

  PatchMatrix patch(std::size_t index) const;
  std::size_t patches() const { return kept_.size(); }

  std::shared_ptr<const SurfaceLightFieldSnapshot> factorize(const BatchFactorization& how) const;

 private:
  struct Kept {
    std::uint32_t image;
    PatchColumn column;
    Eigen::Vector3f eye;
    std::vector<float> reliability;
  };

  std::shared_ptr<const Mesh> mesh_;
  SurfaceLightFieldOptions options_;
  std::size_t every_;
  std::shared_ptr<const MapLayout> maps_;
  std::shared_ptr<const PatchShapes> shapes_;
  std::unique_ptr<SampleVisibility> visibility_;
  RadianceImage image_;
  std::vector<std::vector<Kept>> kept_;  ///< per patch
  std::uint32_t images_ = 0;
};

}  // namespace sheen
