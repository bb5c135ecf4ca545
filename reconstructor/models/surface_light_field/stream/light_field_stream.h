// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/model_stream.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// A surface light field for desks: maps of 8 bits a value (page_tables.h) of the patches that changed, and the view
/// coefficients of the patches that the desk's eye sees. A patch goes with the coefficients of its own basis; where all
/// of it faces away, with those of its means. Changes come before what else the eye sees, which takes longer to find.
class LightFieldStream : public ModelStream {
 public:
  using Clock = std::chrono::steady_clock;
  /// `answer_bytes`: of maps in an answer; it holds one patch at least.
  explicit LightFieldStream(std::size_t answer_bytes = std::size_t{256} << 10);

  void follow(std::shared_ptr<const ModelSnapshot> snapshot, Clock::time_point since) override;
  /// Eight numbers of 32 bits: format, scene, vertices, triangles, patches, columns, samples, edges; `scene_table`
  /// (doubles); vertices (floats); of each triangle its three vertices; `edge_table`; of each triangle its patch, its
  /// first sample among the patch's, samples along a side, and the columns of its corners; of each patch its samples
  /// and its first column.
  std::string scene() override;
  /// Nine numbers: format, scene, changes that the desk has then, whether there are more, patches that follow, whether
  /// it is told of its eye (not while there are more), cameras, the exposure of the eye (a float), and for how many
  /// milliseconds there has been the oldest change that it lacked. Then:
  /// of the eye: a bit per patch, in whole numbers of 32 bits, and of each that is set its coefficients (floats): terms
  /// of a vertex side by side;
  /// of each patch that follows: its number, terms (-1: nothing is known), `MeanRange` (floats); of each term the
  /// coefficient that the means have (a float), and of each what the rest is multiplied with (a float); its
  /// coefficients as above; its means, its terms (`pack_means`, `pack_term`; a sample's terms side by side);
  /// `camera_table`, where this is all that the desk lacked.
  /// A desk of another scene is told the number of this one only.
  std::string changes_for(const DeskState& desk) override;

 private:
  /// What desks see of the model from one eye.
  struct Eye {
    Eigen::Vector3d place;
    std::vector<bool> faced;       ///< per patch: some of it faces the eye
    std::vector<bool> found;       ///< per patch: its coefficients are there
    Eigen::MatrixXf coefficients;  ///< terms x columns
  };
  /// So many changes there were, the last of them since then.
  struct Batch {
    std::uint32_t changes;
    Clock::time_point since;
  };
  /// A patch for all desks. Eight bits hold what is near a mean better than all.
  struct Maps {
    std::string head;  ///< from its number to what the rest is multiplied with
    std::string texels;
  };

  void enter(const SurfaceLightFieldSnapshot& snapshot);
  Eye& eye_at(const Eigen::Vector3d& place);
  /// Of the patches that face the eye, the coefficients of those that are `wanted`.
  void find(const std::vector<std::size_t>& wanted, Eye& eye) const;
  /// terms x vertices
  Eigen::MatrixXf of_patch(const Eye& eye, std::size_t patch) const;
  Maps maps_of(std::size_t patch) const;
  void add_patch(std::size_t patch, const Eye& eye, std::string& answer);
  std::string seen_by(const DeskState& desk, Eye& eye) const;
  std::uint32_t waited_ms(std::uint32_t changes) const;

  std::size_t answer_bytes_;
  std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot_;
  std::uint32_t scene_ = 0, changes_ = 0;
  std::deque<Batch> batches_;  ///< the last ones, the oldest first
  std::vector<std::shared_ptr<const PatchSnapshot>> patches_;
  std::vector<std::uint32_t> changed_at_;              ///< per patch: which change it was; 0: none
  std::vector<std::uint32_t> samples_, first_column_;  ///< per patch; columns also behind the last
  std::vector<std::uint32_t> patch_of_;                ///< per triangle
  std::vector<std::uint32_t> edges_;                   ///< of the scene
  std::vector<Eye> eyes_;                              ///< of `snapshot_`, the latest asked for
  std::vector<Maps> maps_;                             ///< per patch, as far as some desk has asked and there is room
  std::size_t maps_bytes_ = 0;
};

}  // namespace sheen
