// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/light_field_file/edge_blending.h"
#include "reconstructor/light_field_file/eye_coefficients.h"
#include "reconstructor/light_field_file/light_field_reader.h"
#include "reconstructor/light_field_file/page_tables.h"

namespace sheen {

/// A surface light field on its way from a file, of which more and more arrives, to WebGL 2: tables and texels of 8
/// bits. Textures are rows of `kRowTexels`, one behind the other.
class PageModel {
 public:
  static constexpr std::size_t kRowTexels = 4096;

  /// What there is to be drawn.
  enum class Stage : std::uint8_t { kNothing, kMesh, kMeans, kTerms };

  /// `file`: its name in errors.
  explicit PageModel(std::string file) : reader_(std::move(file), one_after_the_other) {}

  /// Reads on until there is more to be drawn; kNothing where that has not arrived yet. `bytes`: the beginning of the
  /// file; `whole`: no more will come. Throws FileError.
  Stage read(std::string_view bytes, bool whole);

  // From kMesh on:
  const Mesh& mesh() const { return *model().mesh; }
  std::vector<double> scene() const { return scene_table(mesh(), model().cameras, brightest_drawn(model())); }
  std::vector<float> cameras() const { return camera_table(model().cameras); }
  std::vector<std::uint32_t> edges() const { return edge_table(mesh()); }

  // From kMeans on:
  /// Twelve numbers per triangle: its vertices, samples along a side; the columns of its corners, its first sample
  /// among all; its first texel of terms, the number of terms (-1: nothing is known), and as bits of floats the
  /// smallest mean of its patch and the range of means. All are encoded colours with white at 1.
  const std::vector<std::uint32_t>& places() const { return places_; }
  /// `pack_means`
  const std::vector<std::uint8_t>& means() const { return means_; }

  // From kTerms on:
  std::size_t term_texels() const { return term_texels_; }  ///< of all terms
  /// The next rows of texels of terms, a sample's terms side by side (`pack_term`); empty behind the last. Coefficients
  /// are there only then.
  const std::vector<std::uint8_t>& next_terms();
  const std::vector<std::uint8_t>& terms() const { return block_; }  ///< that `next_terms` gave last
  /// View coefficients for an eye: `max_terms()` values for each column of `places`, for texels (0..1) less 128 / 255.
  void look_from(const Eigen::Vector3d& eye);
  const Eigen::MatrixXf& coefficients() const { return seen_; }  ///< of the last eye
  int max_terms() const { return coefficients_ ? coefficients_->max_terms() : 0; }
  float exposure_at(const Eigen::Vector3d& eye) const { return model_.model.exposure.at(eye); }
  int missing_layers() const { return model_.model.missing_layers; }

 private:
  const CompactModel& model() const { return ended_ ? model_.model : reader_.read().model; }
  void make_means(const QuantisedModel& quantised);
  void make_places(const QuantisedModel& quantised);
  void pack_terms(std::size_t patch);

  LightFieldReader reader_;
  QuantisedModel model_;  ///< from kTerms on
  std::vector<std::uint32_t> places_;
  std::vector<std::uint8_t> means_, texels_, block_;
  std::vector<MeanRange> mean_ranges_;  ///< per patch
  std::size_t term_texels_ = 0, next_patch_ = 0;
  bool ended_ = false;
  std::optional<EdgeBlending> blending_;
  std::optional<EyeCoefficients> coefficients_;
  Eigen::MatrixXf seen_;
};

}  // namespace sheen
