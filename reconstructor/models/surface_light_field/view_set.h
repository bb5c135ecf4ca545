// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace sheen {

/// A place on the surface, with its unit normal: object frame.
struct SurfaceSite {
  Eigen::Vector3f place = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::UnitZ();
};

/// Views as they are seen from one place on the surface.
struct SiteViews {
  Eigen::Matrix3Xf directions;  ///< unit, to the eyes; a column for each view
  Eigen::VectorXf reliability;  ///< per view, > 0
};

/// From where a patch was seen: an eye for each view of its factor and how far to rely on the view at each of the
/// patch's vertices, in the factor's numbering (OnlineSvd): first the folded views, then those that wait to be. Of the
/// folded ones it keeps which other is the nearest, so that the closest two are found at once when there are too many.
/// Angles between views are those at the patch's centre.
class ViewSet {
 public:
  ViewSet(const Eigen::Vector3f& centre, std::size_t vertices) : centre_(centre), vertices_(vertices) {}

  int count() const { return static_cast<int>(directions_.size()); }
  /// From a vertex, which lies at `place`.
  SiteViews seen_from_vertex(std::size_t vertex, const Eigen::Vector3f& place) const;
  /// Whether another patch that shares this vertex, its `others`, has the same views there, to the last bit.
  bool same_at_vertex(std::size_t vertex, const ViewSet& other, std::size_t others) const;
  /// From the patch's centre; relied on as at its vertices on average.
  SiteViews seen_from_centre() const;

  /// Of the view, and of the angle to it; -1 both where there is no view.
  struct Nearest {
    int view = -1;
    float cosine = -1;
  };
  Nearest nearest(const Eigen::Vector3f& eye) const;
  /// The latest view from exactly there; else the folded one that is nearest, into which it must have been merged.
  int view_from(const Eigen::Vector3f& eye) const;

  /// A view that waits to be folded. `reliability`: at each vertex, > 0.
  void add(const Eigen::Vector3f& eye, std::span<const float> reliability);
  /// So many of the views are folded now.
  void set_folded(int folded);
  int folded() const { return static_cast<int>(neighbours_.size()); }

  /// The two folded views that are nearest to each other, the earlier one first. There must be two.
  std::pair<int, int> closest_pair() const;
  /// The weighted mean takes the place of `kept`; views behind `removed` move up by one.
  void merge(int kept, int removed, float weight_kept, float weight_removed);
  /// A view of this weight from `eye` goes out of the mean that a folded view of weight `weight` is.
  void take_from(int view, float weight, const Eigen::Vector3f& eye, float weight_taken);
  /// Views behind it move up by one.
  void remove(int view);

  std::size_t bytes() const;
  static constexpr std::size_t bytes_for(std::size_t views, std::size_t vertices) {
    return views * (2 * sizeof(Eigen::Vector3f) + vertices * sizeof(float) + sizeof(Neighbour));
  }

 private:
  /// The folded view nearest to a folded view; -1 while it is not known.
  struct Neighbour {
    int view = -1;
    float cosine = -2;
  };

  void place(int view);
  void place_those_left_alone();
  void move(int view, const Eigen::Vector3f& direction, float distance);
  void erase(int view);

  Eigen::Vector3f centre_;
  std::size_t vertices_;
  std::vector<Eigen::Vector3f> eyes_, directions_;  ///< directions: from the centre
  std::vector<float> reliability_;                  ///< of the views one after the other, at all vertices
  std::vector<Neighbour> neighbours_;               ///< for each folded view
};

}  // namespace sheen
