// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/plane_sweep.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace sheen {
namespace {

constexpr int kWindow = 5;                // pixels along a side
constexpr float kMostDifference = 0.15f;  // of encoded values: beyond it another surface is seen
constexpr double kStep = 0.015;           // of the depth: more of it within a window is the edge of a surface
constexpr double kPlaneStep = 0.5;        // pixels
constexpr std::size_t kFewestPlanes = 24, kMostPlanes = 160;
constexpr std::size_t kNeighbours = 8, kNear = 24;

cv::Mat as_mat(const ImageF& image) {
  return cv::Mat(image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data()));
}

/// Pixel of another camera that sees what a pixel of this one shows on a plane at depth z: K' (R K^-1 p + t / z).
cv::Matx33d homography(const PosedCamera& from, const PosedCamera& other, double z) {
  const Rigid3 other_from_camera = other.camera_from_object * from.camera_from_object.inverse();
  const auto matrix = [](const Camera& c) {
    Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
    k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
    return k;
  };
  Eigen::Matrix3d motion = other_from_camera.rotation.toRotationMatrix();
  motion.col(2) += other_from_camera.translation / z;
  const Eigen::Matrix3d h = matrix(other.camera) * motion * matrix(from.camera).inverse();
  return {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)};
}

/// The lower half of eight pictures' values, pixel by pixel, summed: two sorted quartets, of which the lowest four are
/// the lower ones of each pair that is matched from opposite ends.
cv::Mat sum_of_lower_half(std::array<cv::Mat, kNeighbours>& costs) {
  cv::Mat low;
  const auto order = [&](std::size_t a, std::size_t b) {
    cv::min(costs[a], costs[b], low);
    cv::max(costs[a], costs[b], costs[b]);
    cv::swap(low, costs[a]);
  };
  for (const std::size_t first : {std::size_t{0}, std::size_t{4}})
    for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}})
      order(first + static_cast<std::size_t>(a), first + static_cast<std::size_t>(b));
  cv::Mat sum = cv::Mat::zeros(costs[0].size(), CV_32FC1);
  for (std::size_t i = 0; i < 4; ++i) {
    cv::min(costs[i], costs[7 - i], low);
    sum += low;
  }
  return sum;
}

cv::Mat cost_of_plane(const SweepImage& view, std::span<const SweepImage> others, double z) {
  std::array<cv::Mat, kNeighbours> costs;
  const cv::Mat own = as_mat(*view.grey);
  for (std::size_t k = 0; k < std::min(kNeighbours, others.size()); ++k) {
    cv::Mat seen, difference;
    // Outside the other image nothing is known: its border is continued.
    cv::warpPerspective(as_mat(*others[k].grey), seen, homography(view.from, others[k].from, z), own.size(),
                        cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    cv::absdiff(own, seen, difference);
    cv::min(difference, kMostDifference, difference);
    cv::boxFilter(difference, costs[k], -1, {kWindow, kWindow}, {-1, -1}, true, cv::BORDER_REPLICATE);
  }
  // Fewer neighbours are repeated: their better half is the same.
  for (std::size_t k = others.size(); k < kNeighbours; ++k) costs[k] = costs[k - others.size()].clone();
  cv::Mat best, sum = sum_of_lower_half(costs);
  cv::erode(sum, best, cv::Mat::ones(kWindow, kWindow, CV_8U), {-1, -1}, 1, cv::BORDER_REPLICATE);
  return best;
}

}  // namespace

std::vector<double> sweep_planes(const PosedCamera& from, std::span<const SweepImage> others, double near, double far) {
  double baseline = 0;
  for (const SweepImage& other : others)
    baseline = std::max(baseline,
                        (camera_centre(other.from.camera_from_object) - camera_centre(from.camera_from_object)).norm());
  const double pixels = from.camera.fx * baseline * (1 / near - 1 / far);
  const auto count = std::clamp(static_cast<std::size_t>(pixels / kPlaneStep) + 2, kFewestPlanes, kMostPlanes);
  std::vector<double> planes(count);
  for (std::size_t p = 0; p < count; ++p)
    planes[p] = 1 / (1 / near + (1 / far - 1 / near) * static_cast<double>(p) / static_cast<double>(count - 1));
  return planes;
}

SweepCosts::SweepCosts(const SweepImage& view, std::span<const SweepImage> others, std::vector<double> planes)
    : planes_(std::move(planes)), costs_(planes_.size()) {
  tbb::parallel_for(std::size_t{0}, planes_.size(), [&](std::size_t p) {
    const cv::Mat cost = cost_of_plane(view, others, planes_[p]);
    costs_[p] = ImageF(cost.cols, cost.rows, 1);
    cost.copyTo(as_mat(costs_[p]));
  });
}

SweepCosts& SweepCosts::operator+=(const SweepCosts& other) {
  tbb::parallel_for(std::size_t{0}, planes_.size(), [&](std::size_t p) {
    for (std::size_t i = 0; i < costs_[p].size(); ++i) costs_[p].data()[i] += other.costs_[p].data()[i];
  });
  return *this;
}

ImageF SweepCosts::depth() const {
  ImageF depth(costs_[0].width(), costs_[0].height(), 1);
  tbb::parallel_for(0, depth.height(), [&](int y) {
    for (int x = 0; x < depth.width(); ++x) {
      std::size_t best = 0;
      for (std::size_t p = 1; p < planes_.size(); ++p)
        if (costs_[p].at(x, y) < costs_[best].at(x, y)) best = p;
      double offset = 0;
      if (best > 0 && best + 1 < planes_.size()) {
        const double before = costs_[best - 1].at(x, y), at = costs_[best].at(x, y), after = costs_[best + 1].at(x, y);
        const double bend = before - 2 * at + after;
        if (bend > 1e-12) offset = std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
      }
      const double step = 1 / planes_[1] - 1 / planes_[0];
      depth.at(x, y) = static_cast<float>(1 / (1 / planes_[best] + offset * step));
    }
  });
  return depth;
}

ImageF SweepCosts::confidence() const {
  ImageF variance(costs_[0].width(), costs_[0].height(), 1);
  const auto n = static_cast<float>(planes_.size());
  for (std::size_t i = 0; i < variance.size(); ++i) {
    float sum = 0, squares = 0;
    for (const ImageF& cost : costs_) {
      sum += cost.data()[i];
      squares += cost.data()[i] * cost.data()[i];
    }
    variance.data()[i] = std::max(0.0f, squares / n - sum * sum / (n * n));
  }
  ImageF pooled(variance.width(), variance.height(), 1);
  cv::Mat out = as_mat(pooled);
  cv::boxFilter(as_mat(variance), out, -1, {5, 5}, {-1, -1}, true, cv::BORDER_REPLICATE);
  return pooled;
}

ImageF smoothed_depth(const ImageF& depth) {
  ImageF out(depth.width(), depth.height(), 1);
  cv::Mat once, twice, mean, low, high, smooth = as_mat(out);
  cv::medianBlur(as_mat(depth), once, kWindow);
  cv::medianBlur(once, twice, kWindow);
  cv::boxFilter(twice, mean, -1, {kWindow, kWindow}, {-1, -1}, true, cv::BORDER_REPLICATE);
  const cv::Mat square = cv::Mat::ones(kWindow, kWindow, CV_8U);
  cv::erode(twice, low, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::dilate(twice, high, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  twice.copyTo(smooth);
  mean.copyTo(smooth, (high - low) < kStep * twice);
  return out;
}

std::vector<std::size_t> spread_neighbours(std::span<const PosedCamera> cameras, std::size_t view) {
  const auto centre = [&](std::size_t v) { return camera_centre(cameras[v].camera_from_object); };
  std::vector<std::size_t> near(cameras.size());
  std::iota(near.begin(), near.end(), std::size_t{0});
  std::erase(near, view);
  std::stable_sort(near.begin(), near.end(), [&](std::size_t a, std::size_t b) {
    return (centre(a) - centre(view)).norm() < (centre(b) - centre(view)).norm();
  });
  if (near.size() > kNear) near.resize(kNear);
  // One after the other, that which is farthest from those that are taken.
  std::vector<std::size_t> taken;
  while (taken.size() < kNeighbours && !near.empty()) {
    const auto apart = [&](std::size_t v) {
      double least = (centre(v) - centre(view)).norm();
      for (const std::size_t t : taken) least = std::min(least, (centre(v) - centre(t)).norm());
      return least;
    };
    const auto best =
        std::max_element(near.begin(), near.end(), [&](std::size_t a, std::size_t b) { return apart(a) < apart(b); });
    taken.push_back(*best);
    near.erase(best);
  }
  return taken;
}

}  // namespace sheen
