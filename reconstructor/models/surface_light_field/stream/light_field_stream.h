// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/models/model_stream.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

namespace sheen {

/// A surface light field for desks: maps of 8 bits a value (page_tables.h) of the patches that changed, and the view
/// coefficients of all patches that a desk has for its eye. A patch goes with the coefficients of its own basis.
class LightFieldStream : public ModelStream {
 public:
  /// `answer_bytes`: of maps in an answer; it holds one patch at least.
  explicit LightFieldStream(std::size_t answer_bytes = std::size_t{256} << 10);

  void follow(std::shared_ptr<const ModelSnapshot> snapshot) override;
  /// Eight numbers of 32 bits: format, scene, vertices, triangles, patches, columns, samples, edges; `scene_table`
  /// (doubles); vertices (floats); of each triangle its three vertices; `edge_table`; of each triangle its patch, its
  /// first sample among the patch's, samples along a side, and the columns of its corners; of each patch its samples
  /// and its first column.
  std::string scene() override;
  /// Eight numbers: format, scene, changes that the desk has then, whether there are more, patches that follow, whether
  /// it is told of its eye, cameras, and the exposure of the eye (a float). Then:
  /// of the eye: a bit per patch, in whole numbers of 32 bits, and of each that is set its coefficients (floats): terms
  /// of a vertex side by side;
  /// of each patch that follows: its number, terms (-1: nothing is known), `MeanRange` (floats); of each term the
  /// coefficient that the means have (a float), and of each what the rest is multiplied with (a float); its
  /// coefficients as above; its means, its terms (`pack_means`, `pack_term`; a sample's terms side by side);
  /// `camera_table`, where this is all that the desk lacked.
  /// A desk of another scene is told the number of this one only.
  std::string changes_for(const DeskState& desk) override;

 private:
  /// What desks see of the model from one eye: terms x columns.
  struct Eye {
    Eigen::Vector3d place;
    Eigen::MatrixXf coefficients;
  };
  /// A patch for all desks. Eight bits hold what is near a mean better than all: the means are of some eye.
  struct Maps {
    std::string head;  ///< from its number to what the rest is multiplied with
    std::string texels;
  };

  const Eigen::MatrixXf& coefficients_from(const Eigen::Vector3d& eye);
  /// terms x vertices
  Eigen::MatrixXf of_patch(const Eigen::MatrixXf& coefficients, std::size_t patch) const;
  Maps maps_of(std::size_t patch, const Eigen::MatrixXf& coefficients) const;
  void add_patch(std::size_t patch, const Eigen::MatrixXf& coefficients, std::string& answer);

  std::size_t answer_bytes_;
  std::shared_ptr<const LightFieldSnapshot> snapshot_;
  std::uint32_t scene_ = 0, changes_ = 0;
  std::vector<std::shared_ptr<const SurfacePatch>> patches_;
  std::vector<std::uint32_t> changed_at_;              ///< per patch: which change it was; 0: none
  std::vector<std::uint32_t> samples_, first_column_;  ///< per patch; columns also behind the last
  std::vector<Eye> eyes_;                              ///< of `snapshot_`, the latest asked for
  std::vector<Maps> maps_;                             ///< per patch, as far as some desk has asked and there is room
  std::size_t maps_bytes_ = 0;
};

}  // namespace sheen
