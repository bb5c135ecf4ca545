// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/models/surface_light_field/choice_schedule.h"
#include "reconstructor/models/surface_light_field/map_detail.h"
#include "reconstructor/models/surface_light_field/patch_interpolation.h"
#include "reconstructor/models/surface_light_field/view_set.h"
#include "reconstructor/numerics/online_svd.h"

namespace sheen {

/// What patches are cut down to when they take too much memory.
struct PatchLimit {
  int max_rank, internal_rank, block;  ///< as in OnlineSvdOptions
  int max_views;                       ///< as in PatchModelOptions
};

struct PatchModelOptions {
  OnlineSvdOptions factor;
  PatchSize size{.triangles = 2, .samples = 64};
  int max_views = 96;            ///< kept per patch; beyond it the two nearest ones become one
  double min_visible = 0.1;      ///< fraction of a patch's samples that an image must show
  double repeat_angle = 0.0175;  ///< rad from a kept view within which an image may be a repetition of it; 0 = none is
  ViewInterpolationOptions interpolation;
  double residual_memory = 0.7;  ///< of the exponential filter on the projection error (000 sec. 3.3)
  bool coarse_chroma = true;     ///< where it is no finer than a camera's noise; else it stands at every sample

  PatchModelOptions limited_to(const PatchLimit& limit) const;
};

/// As the factor of a patch takes them whose rows are 3 * sample + channel: with the noise of a camera.
OnlineSvdOptions patch_factor_options(OnlineSvdOptions options);

/// Weight of an image in a patch's factor: what it does not show is a guess that only repeats the basis, so it counts
/// for less than its fraction (docs/decisions/missing_samples.md). The paper's imputation has no weights.
double image_weight(const OnlineSvdOptions& options, double fraction_shown);

/// The surface light field of one patch as it grows: the online SVD of what was seen (OnlineSvd) and from where
/// (ViewSet), in the same numbering. How it varies between the views is the vertices' own (InterpolationUpkeep).
///
/// The factor's rows are luma and chroma (ColourPlanes). Chroma gets half of luma's side, and all of it in triangles of
/// which one of the first images shows colours that vary more finely; then what is displayed decides
/// (docs/decisions/surface_maps.md).
class PatchModel {
 public:
  /// `sides`: of its maps. `centre`: of the patch. Patches of differing `phase` fold their columns and want to choose
  /// their interpolation at different images, which spreads the work.
  PatchModel(const MapSides& sides, std::size_t vertices, const SurfaceSite& centre, const PatchModelOptions& options,
             unsigned phase = 0);

  struct Absorbed {
    bool used = false;                 ///< false: too little of the patch is visible
    bool wants_interpolation = false;  ///< enough images have come to choose it again
    double energy = 0;                 ///< of the columns that this one's coming folded: ||c||^2 over what they show
    double residual_energy = 0;        ///< of the same: ||p||^2, what the patch's basis did not predict of them
  };

  /// Ingests what one image shows. `column`: encoded colours, 3 x samples values; those of samples that are not
  /// `visible` mean nothing, here and below. `eye`: object frame. `reliability` in (0, 1], at each vertex, weighs the
  /// image in the interpolation between views.
  Absorbed absorb(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& eye,
                  std::span<const float> reliability);

  void fold_pending();  ///< the images that wait to be folded

  /// Takes out again what an image gave: the arguments are those with which it was absorbed. Exact for the view itself;
  /// what the image left in the others (samples that were imputed with its help, the filtered residual) stays.
  void withdraw(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& eye);

  /// Cosine of the angle at the patch's centre between an eye and the nearest view; -1 when there is none.
  float nearest_cosine(const Eigen::Vector3f& eye) const;
  /// Whether an image from there is near enough to a view to be a repetition of it.
  bool may_repeat(const Eigen::Vector3f& eye) const;
  /// Whether a column from there is also what that view showed, as closely as the basis explains any image: absorbing
  /// it would add nothing. Looks at an eighth of the samples; every sample that it looks at must have been shown
  /// before.
  bool repeats(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& eye) const;

  /// Lets go of terms and views beyond lower limits (OnlineSvd::limit); they hold from now on.
  void limit(const PatchLimit& limit);

  /// How the patch as it stands, before an image is absorbed, predicts the image, interpolated at its centre: over the
  /// values that the image shows and earlier ones did, encoded.
  struct Prediction {
    double squared_error = 0;
    std::size_t values = 0;
  };
  Prediction predict(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible, const Eigen::Vector3f& eye,
                     const SharedInterpolation& interpolation) const;

  bool can_choose_interpolation() const;  ///< there are views enough to say how fast the patch varies
  /// At its centre. Errors with the drift are infinite without a reflection, and with too few views.
  InterpolationErrors interpolation_errors(const ReflectionDrift* reflection) const;
  void interpolation_chosen() {
    schedule_.chosen_at(images_);
    maps_due_ = true;
  }

  /// Whether it is time to ask which sides are enough for its maps: how it interpolates was chosen since, and no column
  /// waits to be folded. Where some samples are shown by less than half of the images that show others, each is
  /// left to say for itself how it is known.
  bool maps_due() const { return maps_due_ && factor_.pending() == 0; }
  /// Makes it so.
  void settle_maps() {
    fold_pending();
    maps_due_ = true;
  }
  /// Of its maps. `detail`: of the error, of all patches or its own, whichever is less, that coarser maps may miss.
  /// `error`: with which images are predicted, RMS, encoded. Maps of chroma get the sides that are enough for them.
  MapSides sufficient_sides(double detail, double error, const SharedInterpolation& interpolation);
  /// Its maps get other sides; columns that wait are folded first.
  void resample(const MapSides& to);
  PatchLevels levels() const;

  int rank() const { return factor_.displayed_rank(); }
  int views() const { return factor_.views(); }
  const OnlineSvd& factor() const { return factor_; }
  std::size_t bytes() const;
  /// Of `snapshot`, whether it is there or not; at most, for patches may share their vertices' views.
  std::size_t snapshot_bytes(std::size_t vertices) const;
  /// Upper bounds of these for a patch of such a size, of many patches by their mean, whatever images come.
  struct Counts {
    double samples, chroma_samples, vertices;
    double rows() const { return samples + 2 * chroma_samples; }
  };
  static double largest_bytes(const Counts& counts, const PatchModelOptions& options);
  static double largest_snapshot_bytes(const Counts& counts, const PatchModelOptions& options);

  /// The patch as it now stands, columns that wait to be folded included; none before an image. Taking it changes
  /// nothing.
  std::optional<FactorizedPatch> factorized() const;
  /// The snapshot made of that, which is kept until something changes; null when it was not made or no longer is true.
  void keep(std::shared_ptr<const PatchSnapshot> snapshot) { snapshot_ = std::move(snapshot); }
  const std::shared_ptr<const PatchSnapshot>& snapshot() const { return snapshot_; }

 private:
  FactorizedPatch settled() const;
  Eigen::MatrixXf mean_shown_colours() const;
  Eigen::MatrixXf with_pending(const Eigen::Ref<const Eigen::MatrixXf>& folded) const;
  Eigen::MatrixXf known_coefficients() const;
  void follow(const OnlineSvd::Reports& reports, Absorbed& result);
  bool shows_enough(std::size_t shown, std::size_t samples) const;
  std::vector<std::uint8_t> known_rows(std::span<const std::uint8_t> visible, std::size_t shown) const;
  void keep_fine_chroma(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible);
  void use(std::shared_ptr<const ColourPlanes> planes);
  void thin_views();

  PatchModelOptions options_;
  SurfaceSite centre_;
  std::shared_ptr<const ColourPlanes> planes_;
  OnlineSvd factor_;
  ViewSet views_;
  ChoiceSchedule schedule_;
  std::vector<std::uint16_t> shown_;  ///< for each sample: images that showed it, as far as the type counts
  int images_ = 0;                    ///< ingested
  int fine_chroma_until_;             ///< from so many images on, none may ask for chroma as fine as luma
  bool maps_due_ = false;
  float residual_ = 1;
  std::shared_ptr<const PatchSnapshot> snapshot_;
};

}  // namespace sheen
