// SPDX-License-Identifier: Apache-2.0
#include "tests/tracker/synthetic_stage.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/stage/tag_pattern.h"

namespace sheen::testing {
namespace {

/// Grey level of a point of the stage's plane.
double stage_level(const StageLayout& stage, const std::vector<TagPattern>& patterns, const Eigen::Vector3d& point,
                   double ink, double paper, double background) {
  if (std::abs(point.x()) > stage.width_m / 2 || std::abs(point.y()) > stage.height_m / 2) return background;
  for (std::size_t i = 0; i < stage.tags.size(); ++i) {
    const auto& corners = stage.tags[i].corners_object;
    const Eigen::Vector3d right = corners[1] - corners[0], down = corners[3] - corners[0];
    const double u = (point - corners[0]).dot(right) / right.squaredNorm();
    const double v = (point - corners[0]).dot(down) / down.squaredNorm();
    if (u < 0 || u >= 1 || v < 0 || v >= 1) continue;
    return patterns[i].white[static_cast<int>(v * kTagCells)][static_cast<int>(u * kTagCells)] ? paper : ink;
  }
  return paper;
}

}  // namespace

Camera stage_camera(bool pinhole) {
  Camera camera{.width = 1024, .height = 768, .fx = 1200, .fy = 1198, .cx = 515.3, .cy = 380.2};
  if (!pinhole) camera.distortion = {-0.12, 0.08, 0.0008, -0.0005, 0};
  return camera;
}

Rigid3 random_stage_pose(std::mt19937& rng, double max_tilt_deg) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double tilt = unit(rng) * max_tilt_deg * M_PI / 180, azimuth = 2 * M_PI * unit(rng);
  const double distance = 0.55 + 0.2 * unit(rng), roll = 2 * M_PI * unit(rng);
  const Eigen::Vector3d eye = distance * Eigen::Vector3d(std::sin(tilt) * std::cos(azimuth),
                                                         std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  const Eigen::Vector3d target(0.02 * (unit(rng) - 0.5), 0.02 * (unit(rng) - 0.5), 0);
  return look_at(eye, target, {std::cos(roll), std::sin(roll), 0.1});
}

std::vector<TagObservation> exact_observations(const Camera& camera, const StageLayout& stage, const Rigid3& pose) {
  std::vector<TagObservation> tags;
  for (const StageTag& tag : stage.tags) {
    TagObservation seen{.id = tag.id};
    bool whole = true;
    for (int corner = 0; corner < 4; ++corner) {
      const auto p = camera.project(pose * tag.corners_object[corner]);
      whole = whole && p && camera.contains(*p, 8);
      if (p) seen.corners[corner] = *p;
    }
    if (whole) tags.push_back(seen);
  }
  return tags;
}

void add_corner_noise(std::vector<TagObservation>& tags, double sigma_px, std::mt19937& rng) {
  std::normal_distribution<double> noise(0, sigma_px);
  for (TagObservation& tag : tags)
    for (Eigen::Vector2d& corner : tag.corners) corner += Eigen::Vector2d(noise(rng), noise(rng));
}

void add_edge_noise(std::vector<TagObservation>& tags, double point_sigma_px, double edge_sigma_px, std::mt19937& rng) {
  std::normal_distribution<double> noise(0, 1);
  for (TagObservation& tag : tags) {
    std::array<Eigen::ParametrizedLine<double, 2>, 4> lines;
    for (int edge = 0; edge < 4; ++edge) {
      const Eigen::Vector2d a = tag.corners[edge], b = tag.corners[(edge + 1) % 4];
      const Eigen::Vector2d along = (b - a).normalized(), across(along.y(), -along.x());
      const double half = (b - a).norm() / 2, reach = std::floor(0.84 * half), shift = edge_sigma_px * noise(rng);
      double count = 0, sum = 0, squares = 0, moment = 0;  // of a straight line by least squares
      for (double s = -reach; s <= reach; ++s) {
        const double off = shift + point_sigma_px * noise(rng);
        ++count;
        sum += off;
        squares += s * s;
        moment += s * off;
      }
      const double place = sum / count, slope = moment / squares;
      lines[edge] = Eigen::ParametrizedLine<double, 2>::Through(a + (place - half * slope) * across,
                                                                b + (place + half * slope) * across);
    }
    for (int corner = 0; corner < 4; ++corner)
      tag.corners[corner] = lines[corner].intersectionPoint(Eigen::Hyperplane<double, 2>(lines[(corner + 3) % 4]));
  }
}

ImageU8 render_stage(const Camera& camera, const StageLayout& stage, const Rigid3& pose, int n, double ink,
                     double paper, double background) {
  std::vector<TagPattern> patterns;
  for (const StageTag& tag : stage.tags) patterns.push_back(tag_pattern(tag.id));
  const Rigid3 object_from_camera = pose.inverse();
  const auto level_at = [&](double x, double y) {
    const Eigen::Vector3d direction = object_from_camera.rotation * *camera.ray({x, y});
    const double distance = -object_from_camera.translation.z() / direction.z();
    const Eigen::Vector3d point = object_from_camera.translation + distance * direction;
    return stage_level(stage, patterns, point, ink, paper, background);
  };
  ImageF between(camera.width + 1, camera.height + 1, 1);  // at the pixels' corners
  for (int y = 0; y <= camera.height; ++y)
    for (int x = 0; x <= camera.width; ++x) between.at(x, y) = static_cast<float>(level_at(x - 0.5, y - 0.5));
  ImageU8 image(camera.width, camera.height, 1);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      // A cell of a tag is several pixels wide, so a pixel with one level at its four corners has no other inside.
      const float level = between.at(x, y);
      double sum = double(level) * n * n;
      if (level != between.at(x + 1, y) || level != between.at(x, y + 1) || level != between.at(x + 1, y + 1)) {
        sum = 0;
        for (int s = 0; s < n * n; ++s) sum += level_at(x - 0.5 + (s % n + 0.5) / n, y - 0.5 + (s / n + 0.5) / n);
      }
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(sum / (n * n)));
    }
  return image;
}

void add_pixel_noise(ImageU8& image, double sigma, std::mt19937& rng) {
  std::normal_distribution<double> noise(0, sigma);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(std::clamp(std::round(image.data()[i] + noise(rng)), 0.0, 255.0));
}

double squared_in_sigmas(const PoseEstimate& pose, const Rigid3& truth) {
  const Eigen::Quaterniond turn = truth.rotation * pose.camera_from_object.rotation.conjugate();
  const Eigen::AngleAxisd angle(turn);
  Eigen::Matrix<double, 6, 1> step;  // in the covariance's parameters
  step << angle.axis() * angle.angle(), truth.translation - turn * pose.camera_from_object.translation;
  return step.dot(pose.covariance.ldlt().solve(step));
}

}  // namespace sheen::testing
