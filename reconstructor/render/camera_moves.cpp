// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/camera_moves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstructor/render/smooth_path.h"

namespace sheen {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kDegree = kTurn / 360;
constexpr double kToSides = 30 * kDegree, kUpAndDown = 12 * kDegree;
constexpr double kFilled = 0.9;         // of the picture's half, by what reaches farthest from its middle
constexpr double kLeastDepth = 1e-3;    // of the distance to the target: what is nearer to the eye frames nothing
constexpr double kWidestTangent = 2.0;  // of half the field of view

PosedCamera camera_at(const LookAt& view, double focal, const ImageSize& size) {
  return {{.width = size.width,
           .height = size.height,
           .fx = focal,
           .fy = focal,
           .cx = (size.width - 1) / 2.0,
           .cy = (size.height - 1) / 2.0},
          look_at(view.eye, view.target, view.up)};
}

std::vector<PosedCamera> cameras_at(std::span<const LookAt> views, double focal, const ImageSize& size) {
  std::vector<PosedCamera> cameras;
  for (const LookAt& view : views) cameras.push_back(camera_at(view, focal, size));
  return cameras;
}

}  // namespace

bool is_a_view(const LookAt& view) {
  const Vector3d forward = view.target - view.eye;
  return view.up.cross(forward).norm() > 1e-6 * view.up.norm() * forward.norm();
}

std::vector<LookAt> turntable(const LookAt& first, int frames) {
  std::vector<LookAt> views;
  for (int i = 0; i < frames; ++i) {
    views.push_back(first);
    const AngleAxisd turn(kTurn * i / frames, first.up.normalized());
    views.back().eye = first.target + turn * (first.eye - first.target);
  }
  return views;
}

std::vector<LookAt> swing(const LookAt& first, int frames) {
  const Vector3d up = first.up.normalized(), arm = first.eye - first.target;
  const Vector3d across = up.cross(arm).norm() > 1e-9 * arm.norm() ? up.cross(arm).normalized() : up.unitOrthogonal();
  std::vector<LookAt> views;
  for (int i = 0; i < frames; ++i) {
    const double at = kTurn * i / frames;
    views.push_back(first);
    views.back().eye = first.target + AngleAxisd(kToSides * std::sin(at), up) *
                                          (AngleAxisd(kUpAndDown * std::sin(2 * at), across) * arm);
  }
  return views;
}

std::vector<LookAt> through(std::span<const LookAt> keys, int frames, bool closed) {
  std::vector<Vector3d> eyes, targets, ups;
  for (const LookAt& key : keys) {
    eyes.push_back(key.eye);
    targets.push_back(key.target);
    ups.push_back(key.up.normalized());
  }
  eyes = smooth_path(eyes, frames, closed);
  targets = smooth_path(targets, frames, closed);
  ups = smooth_path(ups, frames, closed);
  std::vector<LookAt> views;
  for (std::size_t i = 0; i < eyes.size(); ++i) views.push_back({eyes[i], targets[i], ups[i]});
  return views;
}

std::vector<PosedCamera> framed(std::span<const LookAt> views, const Mesh& mesh, const ImageSize& size) {
  double reach = 0;  // of 1 / focal length, in halves of the picture
  for (const LookAt& view : views) {
    const Rigid3 pose = look_at(view.eye, view.target, view.up);
    const double least = kLeastDepth * (view.target - view.eye).norm();
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const Vector3d p = pose * vertex.cast<double>();
      if (p.z() < least) continue;
      reach = std::max({reach, 2 * std::abs(p.x()) / p.z() / size.width, 2 * std::abs(p.y()) / p.z() / size.height});
    }
  }
  reach = std::min(reach, 2 * kWidestTangent / std::min(size.width, size.height));
  return cameras_at(views, kFilled / reach, size);
}

std::vector<PosedCamera> with_field(std::span<const LookAt> views, double degrees, const ImageSize& size) {
  return cameras_at(views, size.height / 2.0 / std::tan(degrees * kDegree / 2), size);
}

}  // namespace sheen
