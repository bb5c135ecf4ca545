// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/render/demand_map.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {

enum class ViewMode {
  kAppearance,  ///< what was captured
  kHeuristic,   ///< where images are missing
  kSplit,       ///< both, side by side from the same eye
  kCamera,      ///< the camera's image, with tags and pose
  kRank,        ///< what the scene required: terms,
  kResolution,  ///< samples along a side of a map,
  kBytes,       ///< memory
  kShape,       ///< from what a found shape is known
};
/// Towards the lights of a model's images, object frame, unit; none where its light stands still.
std::vector<Eigen::Vector3d> light_directions(const ModelSnapshot& model);

const char* to_string(ViewMode mode);
/// Of a mode that shows what the scene required.
std::optional<Demand> demand_of(ViewMode mode);
/// Of "appearance", "heuristic", "split", "camera", "rank", "resolution", "bytes"; nothing for any other word.
std::optional<ViewMode> view_mode_from(std::string_view word);

/// What stands behind the object.
enum class Ground { kDark, kGrey, kLight, kWhite, kBlack };
Ground next(Ground ground);
Eigen::Vector3f color_of(Ground ground);  ///< sRGB-encoded, 0..1

/// What the person at the window has chosen.
struct ViewControls {
  ViewMode mode = ViewMode::kAppearance;
  bool follow = false;   ///< look through the tracked camera instead of the free one
  bool reasons = false;  ///< the heuristic by its reasons
  bool states = false;   ///< tint what is imputed or unseen
  bool help = false;     ///< the list of the keys
  bool details = false;  ///< all figures, not only what comes first
  bool panels = true;    ///< panels and guides over the picture
  Ground ground = Ground::kDark;
  OrbitCamera orbit;
  Eigen::Vector3d light = Eigen::Vector3d::Zero();  ///< see `Viewpoint::light`

  std::optional<Eigen::Vector3d>
      eye;  ///< where the free camera stands at first, in the frame of the mesh's file; empty: `frame` decides

  /// Lets the free camera frame a mesh that it has not framed yet.
  void frame(const std::shared_ptr<const Mesh>& mesh);
  /// The same, as the model's cameras saw it, where it has some: `best_lit_view`. A model whose cameras are known
  /// before its colours is looked at anew when these come, if nobody has moved it.
  void frame(const ModelSnapshot& model);
  void reset();  ///< back to where `frame` put the camera and the light
  /// As `turned_light` does, for whoever looks through the free camera. A light that stands still stays.
  void turn_light(double right_rad, double up_rad);

 private:
  void stand_where_it_opens();

  std::shared_ptr<const Mesh> framed_;
  std::optional<OpeningView> opening_;
  bool without_colours_ = false;         ///< the model, when it was framed
  Viewpoint stood_;                      ///< where it opened
  std::vector<Eigen::Vector3d> lights_;  ///< of the model's images: directions, object frame
};

}  // namespace sheen
