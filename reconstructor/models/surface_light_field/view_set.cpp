// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/view_set.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace sheen {
namespace {

/// For another view, and a few: more would add up, for there are many patches.
template <typename T>
void make_room(std::vector<T>& values, std::size_t per_view) {
  constexpr std::size_t kAtOnce = 4;
  if (values.size() + per_view > values.capacity()) values.reserve(values.size() + kAtOnce * per_view);
}

}  // namespace

SiteViews ViewSet::seen_from_vertex(std::size_t vertex, const Eigen::Vector3f& place) const {
  SiteViews seen{Eigen::Matrix3Xf(3, count()), Eigen::VectorXf(count())};
  for (int j = 0; j < count(); ++j) {
    seen.directions.col(j) = (eyes_[j] - place).normalized();
    seen.reliability[j] = reliability_[static_cast<std::size_t>(j) * vertices_ + vertex];
  }
  return seen;
}

bool ViewSet::same_at_vertex(std::size_t vertex, const ViewSet& other, std::size_t others) const {
  if (eyes_ != other.eyes_) return false;
  for (std::size_t j = 0; j < eyes_.size(); ++j)
    if (reliability_[j * vertices_ + vertex] != other.reliability_[j * other.vertices_ + others]) return false;
  return true;
}

SiteViews ViewSet::seen_from_centre() const {
  SiteViews seen{Eigen::Matrix3Xf(3, count()), Eigen::VectorXf(count())};
  for (int j = 0; j < count(); ++j) {
    seen.directions.col(j) = directions_[j];
    // In their order: a sum in wide instructions begins where the memory happens to lie.
    const auto first = reliability_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(j) * vertices_);
    seen.reliability[j] =
        std::accumulate(first, first + static_cast<std::ptrdiff_t>(vertices_), 0.0f) / static_cast<float>(vertices_);
  }
  return seen;
}

ViewSet::Nearest ViewSet::nearest(const Eigen::Vector3f& eye) const {
  const Eigen::Vector3f direction = (eye - centre_).normalized();
  int nearest = -1;
  float cosine = -std::numeric_limits<float>::infinity();
  for (int view = 0; view < count(); ++view)
    if (const float c = direction.dot(directions_[view]); c > cosine) {
      nearest = view;
      cosine = c;
    }
  return nearest < 0 ? Nearest{} : Nearest{nearest, cosine};
}

int ViewSet::view_from(const Eigen::Vector3f& eye) const {
  const auto same = std::find(eyes_.rbegin(), eyes_.rend(), eye);
  if (same != eyes_.rend()) return static_cast<int>(eyes_.rend() - same) - 1;
  const Eigen::Vector3f direction = (eye - centre_).normalized();
  const auto nearest = std::max_element(
      directions_.begin(), directions_.begin() + folded(),
      [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.dot(direction) < b.dot(direction); });
  return static_cast<int>(nearest - directions_.begin());
}

void ViewSet::add(const Eigen::Vector3f& eye, std::span<const float> reliability) {
  make_room(eyes_, 1);
  make_room(directions_, 1);
  make_room(reliability_, reliability.size());
  eyes_.push_back(eye);
  directions_.push_back((eye - centre_).normalized());
  reliability_.insert(reliability_.end(), reliability.begin(), reliability.end());
}

void ViewSet::set_folded(int folded) {
  neighbours_.reserve(static_cast<std::size_t>(folded));
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
  const float distance =
      (weight_kept * (eyes_[kept] - centre_).norm() + weight_removed * (eyes_[removed] - centre_).norm()) /
      (weight_kept + weight_removed);
  for (std::size_t i = 0; i < vertices_; ++i) {
    float& of_kept = reliability_[static_cast<std::size_t>(kept) * vertices_ + i];
    of_kept = std::max(of_kept, reliability_[static_cast<std::size_t>(removed) * vertices_ + i]);
  }
  erase(removed);
  move(kept, mean, distance);
}

void ViewSet::take_from(int view, float weight, const Eigen::Vector3f& eye, float weight_taken) {
  const Eigen::Vector3f offset = eye - centre_;
  const float left = weight * (eyes_[view] - centre_).norm() - weight_taken * offset.norm();
  move(view, weight * directions_[view] - weight_taken * offset.normalized(), left / (weight - weight_taken));
}

void ViewSet::remove(int view) {
  erase(view);
  place_those_left_alone();
}

/// To another direction, of any length, and distance from the centre.
void ViewSet::move(int view, const Eigen::Vector3f& direction, float distance) {
  directions_[view] = direction.normalized();
  eyes_[view] = centre_ + distance * directions_[view];
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
  const Eigen::Vector3f direction = directions_[view];
  Neighbour nearest;
  for (int other = 0; other < folded(); ++other) {
    if (other == view) continue;
    const float cosine = direction.dot(directions_[other]);
    if (cosine > nearest.cosine) nearest = {other, cosine};
    if (cosine > neighbours_[other].cosine) neighbours_[other] = {view, cosine};
  }
  neighbours_[view] = nearest;
}

/// Those whose neighbour it was are left without (-1).
void ViewSet::erase(int view) {
  eyes_.erase(eyes_.begin() + view);
  directions_.erase(directions_.begin() + view);
  const auto first = reliability_.begin() + static_cast<std::ptrdiff_t>(vertices_) * view;
  reliability_.erase(first, first + static_cast<std::ptrdiff_t>(vertices_));
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
  return bytes_for(directions_.size(), vertices_);
}

}  // namespace sheen
