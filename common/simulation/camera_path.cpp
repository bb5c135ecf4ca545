// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/camera_path.h"

#include <Eigen/Geometry>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/simulation/procedural_noise.h"

namespace sheen {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw ConfigError(std::string("camera path: ") + what);
}

/// Smooth unsteadiness about 0, within [-1, 1]; `channel` names what is unsteady.
double sway(std::uint64_t seed, int channel, int frame) {
  const std::uint64_t h = mix_bits(seed * 64 + channel);
  return gradient_noise({0.31f * frame + 100 * unit_float(h), 100 * unit_float(mix_bits(h)), 7.5f});
}

}  // namespace

Rigid3 CameraStation::at(double moment) const {
  const Eigen::Vector3d rotation = moment * swing;
  const double angle = rotation.norm();
  if (angle == 0) return camera_from_object;
  return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle)), Eigen::Vector3d::Zero()} *
         camera_from_object;
}

double CameraStation::streak_px(const Camera& camera, const Eigen::Vector3d& point) const {
  if (!moves()) return 0;
  const auto from = camera.project(at(-0.5) * point), to = camera.project(at(0.5) * point);
  return from && to ? (*to - *from).norm() : 0;
}

std::vector<CameraStation> camera_path(const CameraPathOptions& o, const Camera& camera) {
  require(o.frames >= 1 && o.frames <= 100000, "frames must be 1..100000");
  require(o.lowest_deg >= 0 && o.lowest_deg < o.highest_deg && o.highest_deg < 90,
          "elevations must rise and lie from 0 to below 90 degrees");
  require(o.nearest_m > 0.1 && o.nearest_m <= o.farthest_m, "distances must rise and exceed 0.1 m");
  require(o.jerk_every >= 0 && o.jerk_px >= 0, "jerks must not be negative");

  const double low = std::sin(o.lowest_deg * kDegree), high = std::sin(o.highest_deg * kDegree);
  const double spacing = std::sqrt(2 * M_PI * (high - low) / o.frames);  // rad between neighbours and between turns
  std::vector<CameraStation> path;
  for (int i = 0; i < o.frames; ++i) {
    const double elevation = std::asin(low + (high - low) * (i + 0.5) / o.frames);
    const double azimuth =
        -M_PI / 2 + 2 * M_PI * (elevation - o.lowest_deg * kDegree) / spacing + 0.3 * spacing * sway(o.seed, 0, i);
    const double steady = (o.nearest_m + o.farthest_m) / 2, reach = (o.farthest_m - o.nearest_m) / 2;
    const double distance = steady + reach * sway(o.seed, 1, i);
    const Eigen::Vector3d out(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                              std::sin(elevation));
    const Eigen::Vector3d aim(sway(o.seed, 2, i), sway(o.seed, 3, i), sway(o.seed, 4, i));
    CameraStation station;
    const Rigid3 roll{Eigen::Quaterniond(Eigen::AngleAxisd(o.roll_jitter_deg * kDegree * sway(o.seed, 5, i),
                                                           Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
    station.camera_from_object =
        roll * look_at(o.target + distance * out, o.target + o.aim_jitter_m * aim, Eigen::Vector3d::UnitZ());
    if (o.jerk_every > 0 && i % o.jerk_every == o.jerk_every * 5 / 8 && o.jerk_px > 0) {
      const double heading = 2 * M_PI * unit_float(mix_bits(o.seed * 1000003 + i));
      station.swing = o.jerk_px / camera.fx * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    }
    path.push_back(station);
  }
  return path;
}

Camera simulated_camera(int width, int height) {
  const Camera full{.width = 1024,
                    .height = 768,
                    .fx = 1200,
                    .fy = 1200,
                    .cx = 515.3,
                    .cy = 380.6,
                    .lens = LensModel::kOpenCv,
                    .distortion = {-0.10, 0.02, 0.0006, -0.0004, 0}};
  return full.scaled(width, height);
}

}  // namespace sheen
