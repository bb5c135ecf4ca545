// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_set.h"

#include <algorithm>

namespace sheen {

Eigen::Matrix3Xf ViewSet::direction_matrix() const {
  Eigen::Matrix3Xf m(3, static_cast<Eigen::Index>(directions_.size()));
  for (std::size_t i = 0; i < directions_.size(); ++i) m.col(static_cast<Eigen::Index>(i)) = directions_[i];
  return m;
}

ViewSet::Nearest ViewSet::nearest(const Eigen::Vector3f& direction) const {
  Nearest nearest;
  for (int view = 0; view < count(); ++view)
    if (const float c = direction.dot(directions_[view]); nearest.view < 0 || c > nearest.cosine) nearest = {view, c};
  return nearest;
}

int ViewSet::view_from(const Eigen::Vector3f& direction) const {
  const auto same = std::find(directions_.rbegin(), directions_.rend(), direction);
  if (same != directions_.rend()) return static_cast<int>(directions_.rend() - same) - 1;
  const auto nearest = std::max_element(
      directions_.begin(), directions_.begin() + folded(),
      [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.dot(direction) < b.dot(direction); });
  return static_cast<int>(nearest - directions_.begin());
}

void ViewSet::add(const Eigen::Vector3f& direction, float reliability) {
  directions_.push_back(direction);
  reliability_.push_back(reliability);
}

void ViewSet::set_folded(int folded) {
  while (this->folded() < folded) {
    neighbours_.emplace_back();
    place(this->folded() - 1);
  }
}

std::pair<int, int> ViewSet::closest_pair() const {
  const auto closest = std::max_element(neighbours_.begin(), neighbours_.end(),
                                        [](const Neighbour& a, const Neighbour& b) { return a.cosine < b.cosine; });
  return std::minmax({static_cast<int>(closest - neighbours_.begin()), closest->view});
}

void ViewSet::merge(int kept, int removed, float weight_kept, float weight_removed) {
  const Eigen::Vector3f mean = weight_kept * directions_[kept] + weight_removed * directions_[removed];
  reliability_[kept] = std::max(reliability_[kept], reliability_[removed]);
  erase(removed);
  move(kept, mean);
}

void ViewSet::take_from(int view, float weight, const Eigen::Vector3f& direction, float weight_taken) {
  move(view, weight * directions_[view] - weight_taken * direction);
}

void ViewSet::remove(int view) {
  erase(view);
  place_those_left_alone();
}

/// To another direction, of any length.
void ViewSet::move(int view, const Eigen::Vector3f& direction) {
  directions_[view] = direction.normalized();
  for (Neighbour& neighbour : neighbours_)
    if (neighbour.view == view) neighbour = {};
  place(view);
  place_those_left_alone();
}

/// Finds the neighbour of those that have lost it.
void ViewSet::place_those_left_alone() {
  for (int view = 0; view < folded(); ++view)
    if (neighbours_[view].view < 0) place(view);
}

/// Finds the neighbour of this view, and whose it now is.
void ViewSet::place(int view) {
  neighbours_[view] = {};
  for (int other = 0; other < folded(); ++other) {
    if (other == view) continue;
    const float cosine = directions_[view].dot(directions_[other]);
    if (cosine > neighbours_[view].cosine) neighbours_[view] = {other, cosine};
    if (cosine > neighbours_[other].cosine) neighbours_[other] = {view, cosine};
  }
}

/// Those whose neighbour it was are left without (-1).
void ViewSet::erase(int view) {
  directions_.erase(directions_.begin() + view);
  reliability_.erase(reliability_.begin() + view);
  if (view >= folded()) return;
  neighbours_.erase(neighbours_.begin() + view);
  for (Neighbour& neighbour : neighbours_) {
    if (neighbour.view == view)
      neighbour = {};
    else if (neighbour.view > view)
      --neighbour.view;
  }
}

std::size_t ViewSet::bytes() const {
  return directions_.size() * (sizeof(Eigen::Vector3f) + sizeof(float)) + neighbours_.size() * sizeof(Neighbour);
}

}  // namespace sheen
