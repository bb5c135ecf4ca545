// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/held_out_curve.h"

#include <algorithm>
#include <cmath>

#include "common/base/angle.h"

namespace sheen {
namespace {

constexpr std::size_t kMostViews = 4;
constexpr double kMostPixels = 4e6;
constexpr double kApart_rad = 25 * kDegree;

}  // namespace

std::vector<std::size_t> judging_panel(const std::vector<HeldOutView>& held_out, const Eigen::Vector3d& centre) {
  const auto direction = [&](std::size_t i) {
    return (camera_centre(held_out[i].camera_from_object) - centre).normalized().eval();
  };
  std::vector<std::size_t> panel;
  double pixels = 0;
  for (std::size_t i = 0; i < held_out.size() && panel.size() < kMostViews; ++i) {
    const bool apart = std::all_of(panel.begin(), panel.end(), [&](std::size_t other) {
      return direction(i).dot(direction(other)) <= std::cos(kApart_rad);
    });
    const double its_pixels = static_cast<double>(held_out[i].camera.width) * held_out[i].camera.height;
    if (!apart || (!panel.empty() && pixels + its_pixels > kMostPixels)) continue;
    panel.push_back(i);
    pixels += its_pixels;
  }
  return panel;
}

void HeldOutCurve::judge(const std::vector<HeldOutView>& held_out, const std::vector<std::size_t>& panel,
                         std::uint64_t images, const Appearance& model, const Appearance& constant,
                         const RayPainter& painter) {
  std::vector<std::pair<std::string, std::uint64_t>> names;
  HeldOutPoint point{.images = images};
  const double weight = 1.0 / static_cast<double>(panel.size());
  for (const std::size_t i : panel) {
    const HeldOutView& view = held_out[i];
    names.emplace_back(view.source_session, view.sequence);
    const ObjectScore s = score_object(view, model, painter);
    point.psnr_db += weight * s.psnr_db;
    point.ssim += weight * s.ssim;
    point.constant_psnr_db += weight * score_object(view, constant, painter).psnr_db;
  }
  if (names != panel_) points_.clear();
  panel_ = std::move(names);
  add(point);
}

void HeldOutCurve::add(const HeldOutPoint& point) {
  if (points_.size() == kMostPoints) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points_.size(); i += 2) points_[kept++] = points_[i];
    points_.resize(kept);
  }
  points_.push_back(point);
}

}  // namespace sheen
