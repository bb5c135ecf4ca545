// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "reconstructor/lumigraph_file/lumigraph_data.h"
#include "reconstructor/models/intrinsic_lumigraph/mean_look.h"

namespace sheen {

/// The views round an eye, relit, ready to be asked for the colours of surface points: the lumigraph's
/// interpolation between views.
class ViewBlend {
 public:
  /// Makes, or remembers, the colours of a view; what it leaves empty in `dark` is as `lit`.
  using Relight = std::function<std::shared_ptr<const RelitView>(const IntrinsicView&)>;
  ViewBlend(const std::shared_ptr<const LumigraphData>& data, const Eigen::Vector3d& eye, const Relight& relit);

  struct Colours : LitAndDark {
    float known = 0;  ///< 0..1: of the weights, that of the views which show the point; 0: what stands before it
  };
  /// A view counts where its depth agrees with the point's and it is on the side that the point is seen from, `facing`
  /// (unit): the inside of an open object does not look like its outside. Zero: the point has no sides. None
  /// where it is beside all images.
  std::optional<Colours> at(const Eigen::Vector3f& point,
                            const Eigen::Vector3f& facing = Eigen::Vector3f::Zero()) const;

  /// Where a ray meets what a view shows, by its depth map: the heaviest view in whose image that is. None where it is
  /// beside all of them. `guess`: a point of the ray.
  std::optional<Eigen::Vector3f> along(const Eigen::Vector3f& eye, const Eigen::Vector3f& guess) const;

 private:
  float slant_weight(const Eigen::Vector3f& point, const Eigen::Vector3f& facing, const Eigen::Vector3f& from) const;
  static std::optional<Eigen::Vector3f> along(const IntrinsicView& view, const Eigen::Vector3f& eye,
                                              const Eigen::Vector3f& guess);

  struct Prepared {
    std::shared_ptr<const IntrinsicView> view;
    float weight = 1;
    std::shared_ptr<const RelitView> relit;
    Eigen::Matrix3d rotation;  ///< camera_from_object
    Eigen::Vector3f eye;
  };
  Eigen::Vector3f eye_;
  std::vector<Prepared> views_;  ///< the heaviest first
};

}  // namespace sheen
