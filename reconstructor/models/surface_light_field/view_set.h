// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace sheen {

/// From where a ring was seen: a direction for each view of its factor and how reliable the view is, in the factor's
/// numbering (RingFactor): first the folded views, then those that wait to be. Of the folded ones it keeps which other
/// is the nearest, so that the closest two are found at once when there are too many.
class ViewSet {
 public:
  int count() const { return static_cast<int>(directions_.size()); }
  const std::vector<Eigen::Vector3f>& directions() const { return directions_; }
  Eigen::Matrix3Xf direction_matrix() const;  ///< a column for each view
  auto reliability() const { return Eigen::Map<const Eigen::VectorXf>(reliability_.data(), count()); }

  /// Of the view, and of the angle to it; -1 both where there is no view.
  struct Nearest {
    int view = -1;
    float cosine = -1;
  };
  Nearest nearest(const Eigen::Vector3f& direction) const;
  /// The latest view from exactly there; else the folded one that is nearest, into which it must have been merged.
  int view_from(const Eigen::Vector3f& direction) const;

  /// A view that waits to be folded.
  void add(const Eigen::Vector3f& direction, float reliability);
  /// So many of the views are folded now.
  void set_folded(int folded);
  int folded() const { return static_cast<int>(neighbours_.size()); }

  /// The two folded views that are nearest to each other, the earlier one first. There must be two.
  std::pair<int, int> closest_pair() const;
  /// The weighted mean takes the place of `kept`; views behind `removed` move up by one.
  void merge(int kept, int removed, float weight_kept, float weight_removed);
  /// A view of this weight from `direction` goes out of the mean that a folded view of weight `weight` is.
  void take_from(int view, float weight, const Eigen::Vector3f& direction, float weight_taken);
  /// Views behind it move up by one.
  void remove(int view);

  std::size_t bytes() const;
  static constexpr std::size_t bytes_for(std::size_t views) {
    return views * (sizeof(Eigen::Vector3f) + sizeof(float) + sizeof(Neighbour));
  }

 private:
  /// The folded view nearest to a folded view; -1 while it is not known.
  struct Neighbour {
    int view = -1;
    float cosine = -2;
  };

  void place(int view);
  void place_those_left_alone();
  void move(int view, const Eigen::Vector3f& direction);
  void erase(int view);

  std::vector<Eigen::Vector3f> directions_;
  std::vector<float> reliability_;
  std::vector<Neighbour> neighbours_;  ///< for each folded view
};

}  // namespace sheen
