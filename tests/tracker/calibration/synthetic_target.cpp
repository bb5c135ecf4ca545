// SPDX-License-Identifier: Apache-2.0
#include "tests/tracker/calibration/synthetic_target.h"

#include <cmath>
#include <stdexcept>

namespace sheen::testing {

Camera ordinary_camera() {
  return {.width = 800,
          .height = 600,
          .fx = 650,
          .fy = 650,
          .cx = 407.3,
          .cy = 292.8,
          .distortion = {-0.21, 0.09, 0.0011, -0.0007, -0.02}};
}

Camera fisheye_camera() {
  return {.width = 800,
          .height = 600,
          .fx = 430,
          .fy = 430,
          .cx = 396.1,
          .cy = 305.4,
          .lens = LensModel::kFisheye,
          .distortion = {-0.02, 0.006, -0.004, 0.001, 0}};
}

Rigid3 random_target_pose(const Camera& camera, std::span<const Eigen::Vector3d> target, std::mt19937& rng,
                          const TargetPoses& poses) {
  std::uniform_real_distribution<double> unit(0, 1);
  Eigen::Vector3d low = target[0], high = target[0];
  for (const Eigen::Vector3d& p : target) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d middle = (low + high) / 2;
  const double filling = (high - low).norm() / 2 * camera.fy / (camera.height / 2.0);
  for (int attempt = 0; attempt < 10'000; ++attempt) {
    const auto place = [&](int size) { return size * (0.5 + poses.spread * (unit(rng) - 0.5)); };
    const auto ray = camera.ray({place(camera.width), place(camera.height)});
    if (!ray) continue;
    const double distance = filling * (poses.least_distance + unit(rng) * (poses.most_distance - poses.least_distance));
    const double tilt = poses.most_tilt_deg * M_PI / 180 * unit(rng), azimuth = 2 * M_PI * unit(rng);
    const Eigen::AngleAxisd lean(tilt, Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
    const Eigen::AngleAxisd roll(2 * M_PI * unit(rng), Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd face(poses.z_up ? M_PI : 0, Eigen::Vector3d::UnitX());
    const Eigen::Quaterniond rotation(lean * roll * face);
    const Rigid3 pose{rotation, *ray * distance - rotation * middle};
    bool whole = true;
    for (const Eigen::Vector3d& p : target) {
      const auto pixel = camera.project(pose * p);
      whole = whole && pixel && camera.contains(*pixel, 4);
    }
    if (whole) return pose;
  }
  throw std::logic_error("no pose shows the whole target");
}

std::vector<TargetView> simulated_views(const Camera& camera, std::span<const Eigen::Vector3d> target, int views,
                                        double noise_px, std::mt19937& rng, const TargetPoses& poses) {
  std::normal_distribution<double> noise(0, 1);
  std::vector<TargetView> result;
  for (int view = 0; view < views; ++view) {
    const Rigid3 pose = random_target_pose(camera, target, rng, poses);
    result.push_back({"view" + std::to_string(view) + ".png", {}});
    for (int i = 0; i < static_cast<int>(target.size()); ++i)
      result.back().sightings.push_back(
          {i, *camera.project(pose * target[i]) + noise_px * Eigen::Vector2d(noise(rng), noise(rng))});
  }
  return result;
}

ImageU8 render_plane(const Camera& camera, const Rigid3& camera_from_target,
                     const std::function<double(double x, double y)>& level) {
  constexpr int kSamples = 6;
  const Rigid3 target_from_camera = camera_from_target.inverse();
  const auto plane_at = [&](double x, double y) -> Eigen::Vector2d {
    const Eigen::Vector3d direction = target_from_camera.rotation * *camera.ray({x, y});
    const double distance = -target_from_camera.translation.z() / direction.z();
    return (target_from_camera.translation + distance * direction).head<2>();
  };
  std::vector<Eigen::Vector2d> corners;
  for (int y = 0; y <= camera.height; ++y)
    for (int x = 0; x <= camera.width; ++x) corners.push_back(plane_at(x - 0.5, y - 0.5));
  ImageU8 image(camera.width, camera.height, 1);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d* top = &corners[std::size_t(y) * (camera.width + 1) + x];
      const Eigen::Vector2d* bottom = top + camera.width + 1;
      double sum = 0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double u = (s % kSamples + 0.5) / kSamples, v = (s / kSamples + 0.5) / kSamples;
        const Eigen::Vector2d point =
            (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * bottom[0] + u * bottom[1]);
        sum += level(point.x(), point.y());
      }
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(sum / (kSamples * kSamples)));
    }
  return image;
}

}  // namespace sheen::testing
