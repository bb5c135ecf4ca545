// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/plane_sweep.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace sheen {
namespace {

constexpr int kWindow = 5, kRefiningWindow = 3;  // pixels along a side
constexpr float kMostDifference = 0.15f;         // of encoded values: beyond it another surface is seen
constexpr double kSmallDifference = 0.02;
constexpr double kStep = 0.015;     // of the depth: more of it within a window is the edge of a surface
constexpr double kPlaneStep = 0.5;  // pixels
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

/// The two lowest of eight pictures' values, pixel by pixel, summed.
cv::Mat sum_of_two_lowest(const std::array<cv::Mat, kNeighbours>& costs) {
  cv::Mat lowest, second, higher;
  cv::min(costs[0], costs[1], lowest);
  cv::max(costs[0], costs[1], second);
  for (std::size_t k = 2; k < costs.size(); ++k) {
    cv::max(lowest, costs[k], higher);
    cv::min(second, higher, second);
    cv::min(lowest, costs[k], lowest);
  }
  return lowest + second;
}

/// The lower half of them: two sorted quartets, of which the lowest four are the lower ones of each pair that is
/// matched from opposite ends.
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

using NeighbourCosts = std::array<cv::Mat, kNeighbours>;

/// Differences of a part of a view's image from each neighbour's by a plane, each taken through `measure` and averaged
/// over a window.
template <typename Measure>
NeighbourCosts differences(const SweepImage& view, std::span<const SweepImage> others, const PixelBox& part, double z,
                           cv::InterpolationFlags interpolation, int window, const Measure& measure) {
  NeighbourCosts costs;
  const cv::Mat own = as_mat(*view.grey)(cv::Rect(part.x0, part.y0, part.width(), part.height()));
  const cv::Matx33d to_part(1, 0, part.x0, 0, 1, part.y0, 0, 0, 1);
  for (std::size_t k = 0; k < std::min(kNeighbours, others.size()); ++k) {
    cv::Mat seen, difference;
    // Outside the other image nothing is known: its border is continued.
    cv::warpPerspective(as_mat(*others[k].grey), seen, homography(view.from, others[k].from, z) * to_part, own.size(),
                        interpolation | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    cv::absdiff(own, seen, difference);
    cv::min(difference, kMostDifference, difference);
    measure(difference);
    cv::boxFilter(difference, costs[k], -1, {window, window}, {-1, -1}, true, cv::BORDER_REPLICATE);
  }
  // Fewer neighbours are repeated.
  for (std::size_t k = others.size(); k < kNeighbours; ++k) costs[k] = costs[k - others.size()].clone();
  return costs;
}

/// To choose a plane by: windows shift, so that they need not lie across an edge, and two neighbours that agree are
/// enough, for those that look past an edge of what stands before may be most.
cv::Mat choosing_cost(const SweepImage& view, std::span<const SweepImage> others, double z) {
  const PixelBox all{0, 0, view.grey->width(), view.grey->height()};
  cv::Mat best;
  cv::erode(sum_of_two_lowest(differences(view, others, all, z, cv::INTER_LINEAR, kWindow, [](cv::Mat&) {})), best,
            cv::Mat::ones(kWindow, kWindow, CV_8U), {-1, -1}, 1, cv::BORDER_REPLICATE);
  return best;
}

/// To go between planes by: with windows that stay, for where others shift to a slanted surface lies in the plane; with
/// differences that are squared where they are small, so that a parabola follows them.
cv::Mat refining_cost(const SweepImage& view, std::span<const SweepImage> others, const PixelBox& part, double z) {
  NeighbourCosts costs = differences(view, others, part, z, cv::INTER_CUBIC, kRefiningWindow, [](cv::Mat& difference) {
    cv::multiply(difference, difference, difference);
    cv::sqrt(difference + kSmallDifference * kSmallDifference, difference);
  });
  return sum_of_lower_half(costs);
}

/// Where a parabola through three costs, a plane apart, has its minimum: planes from the middle one, `most` at most.
double minimum_offset(double before, double at, double after, double most) {
  const double bend = before - 2 * at + after;
  return bend > 1e-12 ? std::clamp(0.5 * (before - after) / bend, -most, most) : 0;
}

float depth_between(const std::vector<double>& planes, std::size_t plane, double offset) {
  return static_cast<float>(1 / (1 / planes[plane] + offset * (1 / planes[1] - 1 / planes[0])));
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
    const cv::Mat cost = choosing_cost(view, others, planes_[p]);
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

Image<std::uint16_t> SweepCosts::best_planes() const {
  Image<std::uint16_t> best(costs_[0].width(), costs_[0].height(), 1);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, best.size(), 4096), [&](const auto& range) {
    for (std::size_t p = 1; p < planes_.size(); ++p)
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        if (costs_[p].data()[i] < costs_[best.data()[i]].data()[i]) best.data()[i] = static_cast<std::uint16_t>(p);
  });
  return best;
}

ImageF SweepCosts::depth() const {
  const Image<std::uint16_t> best = best_planes();
  ImageF depth(best.width(), best.height(), 1);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::size_t p = best.data()[i];
    const auto cost = [&](std::size_t plane) { return static_cast<double>(costs_[plane].data()[i]); };
    const bool inner = p > 0 && p + 1 < planes_.size();
    depth.data()[i] = depth_between(planes_, p, inner ? minimum_offset(cost(p - 1), cost(p), cost(p + 1), 0.5) : 0);
  }
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

RefinedDepth::RefinedDepth(std::vector<double> planes, Image<std::uint16_t> best)
    : planes_(std::move(planes)),
      best_(std::move(best)),
      parts_(planes_.size(), PixelBox{best_.width(), best_.height(), 0, 0}),
      costs_(best_.width(), best_.height(), 3) {
  for (int y = 0; y < best_.height(); ++y)
    for (int x = 0; x < best_.width(); ++x)
      for (std::size_t p = best_.at(x, y) > 0 ? best_.at(x, y) - 1 : 0; p < planes_.size() && p <= best_.at(x, y) + 1u;
           ++p) {
        PixelBox& part = parts_[p];
        part = {std::min(part.x0, x), std::min(part.y0, y), std::max(part.x1, x + 1), std::max(part.y1, y + 1)};
      }
}

void RefinedDepth::add(const SweepImage& view, std::span<const SweepImage> others) {
  tbb::parallel_for(std::size_t{0}, planes_.size(), [&](std::size_t p) {
    if (parts_[p].empty()) return;
    constexpr int kMargin = kRefiningWindow / 2;
    const PixelBox part{std::max(parts_[p].x0 - kMargin, 0), std::max(parts_[p].y0 - kMargin, 0),
                        std::min(parts_[p].x1 + kMargin, best_.width()),
                        std::min(parts_[p].y1 + kMargin, best_.height())};
    const cv::Mat cost = refining_cost(view, others, part, planes_[p]);
    for (int y = parts_[p].y0; y < parts_[p].y1; ++y)
      for (int x = parts_[p].x0; x < parts_[p].x1; ++x)
        if (const std::size_t place = p + 1 - best_.at(x, y); place < 3)  // wraps round where the plane is nearer
          costs_.at(x, y, static_cast<int>(place)) += cost.at<float>(y - part.y0, x - part.x0);
  });
}

ImageF RefinedDepth::depth() const {
  ImageF depth(best_.width(), best_.height(), 1);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::size_t p = best_.data()[i];
    const float* cost = costs_.data() + 3 * i;
    const bool inner = p > 0 && p + 1 < planes_.size();
    depth.data()[i] = depth_between(planes_, p, inner ? minimum_offset(cost[0], cost[1], cost[2], 1) : 0);
  }
  return depth;
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
