// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "common/stage/stage_layout.h"
#include "common/stage/tag_pattern.h"
#include "tests/support/analytic_scene.h"

namespace sheen {

/// A ball on a printed sheet on a brown table, drawn point by point: what is printed is read from the patterns of the
/// tags, the ball is hit by its formula.
struct StagePhotograph {
  StageLayout stage = make_stage({});
  Eigen::Vector3d centre{0.01, 0, 0.045};
  double radius = 0.045;
  std::function<Eigen::Array3d(const Eigen::Vector3d& normal)> ball = [](const Eigen::Vector3d& n) {
    return Eigen::Array3d(0.5 + 0.2 * std::sin(30 * n.x()), 0.2, 0.15 + 0.1 * std::cos(25 * n.y()));
  };
  /// Light on a place of the sheet, RGB.
  std::function<Eigen::Array3d(const Eigen::Vector2d& place)> light = [](const Eigen::Vector2d&) {
    return Eigen::Array3d(Eigen::Array3d::Ones());
  };
  Eigen::Array3d gain{1, 1, 1};  ///< of the camera
  double noise = 0.004;

  Eigen::Array3d printed(const Eigen::Vector2d& place) const {
    if (std::abs(place.x()) > stage.width_m / 2 || std::abs(place.y()) > stage.height_m / 2) return {0.2, 0.13, 0.08};
    for (const StageTag& tag : stage.tags) {
      const Eigen::Vector2d corner = tag.corners_object[0].head<2>();
      const Eigen::Vector2d right = tag.corners_object[1].head<2>() - corner;
      const Eigen::Vector2d down = tag.corners_object[3].head<2>() - corner;
      const double column = kTagCells * right.dot(place - corner) / right.squaredNorm();
      const double row = kTagCells * down.dot(place - corner) / down.squaredNorm();
      if (column < 0 || row < 0 || column >= kTagCells || row >= kTagCells) continue;
      static std::map<int, TagPattern> patterns;
      const auto pattern = patterns.try_emplace(tag.id, tag_pattern(tag.id)).first;
      return pattern->second.white[static_cast<int>(row)][static_cast<int>(column)] ? kPaper : kInk;
    }
    return kPaper;
  }
  static inline const Eigen::Array3d kPaper{0.6, 0.6, 0.58}, kInk{0.04, 0.04, 0.045};

  struct Seen {
    ImageF colour;
    ImageU8 ball;        ///< 1 where the middle of the pixel shows it
    ImageU8 bare_sheet;  ///< 1 where it shows the sheet between the tags' outer edges
  };
  Seen seen_by(const Camera& camera, const Rigid3& camera_from_object) const {
    constexpr int kPoints = 4;  // along a pixel
    const Rigid3 object_from_camera = camera_from_object.inverse();
    const Eigen::Vector3d eye = object_from_camera.translation;
    Seen seen{ImageF(camera.width, camera.height, 3), ImageU8(camera.width, camera.height, 1),
              ImageU8(camera.width, camera.height, 1)};
    std::mt19937 chance(7);
    std::normal_distribution<double> off(0, noise);
    const analytic::Surface sphere = analytic::sphere(radius);
    const auto look = [&](double x, double y, std::uint8_t* is_ball, std::uint8_t* is_sheet) -> Eigen::Array3d {
      const Eigen::Vector3d ray = object_from_camera.rotation * *camera.ray({x, y});
      if (const double t = sphere(eye - centre, ray); t < analytic::kMiss) {
        if (is_ball) *is_ball = 1;
        const Eigen::Vector3d normal = (eye + t * ray - centre) / radius;
        return ball(normal) * (0.35 + 0.65 * std::max(0.0, normal.z()));
      }
      if (!(ray.z() < 0)) return {0.3, 0.3, 0.32};
      const Eigen::Vector2d place = (eye - eye.z() / ray.z() * ray).head<2>();
      if (is_sheet && std::abs(place.x()) < 0.185 && std::abs(place.y()) < 0.135) *is_sheet = 1;
      return printed(place) * light(place);
    };
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        Eigen::Array3d sum = Eigen::Array3d::Zero();
        for (int i = 0; i < kPoints * kPoints; ++i)
          sum +=
              look(x + (i % kPoints + 0.5) / kPoints - 0.5, y + (i / kPoints + 0.5) / kPoints - 0.5, nullptr, nullptr);
        look(x, y, &seen.ball.at(x, y), &seen.bare_sheet.at(x, y));
        for (int c = 0; c < 3; ++c)
          seen.colour.at(x, y, c) =
              static_cast<float>(std::max(0.0, gain[c] * sum[c] / (kPoints * kPoints) + off(chance)));
      }
    return seen;
  }
};

}  // namespace sheen
