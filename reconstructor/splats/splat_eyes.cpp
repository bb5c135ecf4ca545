// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splat_eyes.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kNear = 240, kRound = 60, kCheck = 12;
constexpr std::size_t kNeighbours = 6;            ///< of an image's eye: others, that eyes are between
constexpr double kPixelsPerSplat = 5;             ///< of pictures, about
constexpr int kLeastSide = 16, kMostSide = 2048;  ///< of a picture, pixels
constexpr double kDistance = 3;                   ///< where there are no images, in radii of the object
constexpr double kLeastDistance = 1.2;            ///< of the eyes all round, in radii

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Multiples of these, less the whole, are spread evenly: of the first two in a square, of the third on a line.
constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532, kGolden = 0.3819660112501051;
double spread(std::size_t i, double number) {
  return std::fmod(0.5 + static_cast<double>(i) * number, 1.0);
}

/// Between an eye of the images and one of those that are nearest to it.
Vector3d eye_between(const std::vector<Vector3d>& images, std::size_t i) {
  const Vector3d& eye = images[std::size_t(spread(i, kFirst) * static_cast<double>(images.size()))];
  std::vector<Vector3d> nearest = images;
  const std::size_t count = std::min(images.size(), kNeighbours + 1);
  std::partial_sort(
      nearest.begin(), nearest.begin() + std::ptrdiff_t(count), nearest.end(),
      [&](const Vector3d& a, const Vector3d& b) { return (a - eye).squaredNorm() < (b - eye).squaredNorm(); });
  return eye + spread(i, kSecond) * (nearest[i % count] - eye);
}

/// On a spiral from pole to pole.
Vector3d direction_round(std::size_t i) {
  const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(kRound);
  const double turn = 2 * M_PI * spread(i, kGolden), width = std::sqrt(1 - z * z);
  return {width * std::cos(turn), width * std::sin(turn), z};
}

/// `pitch`: metres of the object per pixel.
PosedCamera camera_at(const Vector3d& eye, const BoundingSphere& object, double pitch) {
  const Vector3d back = eye - object.centre;
  const double distance = std::max(back.norm(), 1e-3 * object.radius);
  const double sine = std::min(object.radius / distance, std::sqrt(0.5));
  PosedCamera from;
  Camera& camera = from.camera;
  camera.fx = camera.fy = distance / pitch;
  const int side = std::clamp(int(2 * camera.fx * sine / std::sqrt(1 - sine * sine)), kLeastSide, kMostSide);
  camera.width = camera.height = side;
  camera.cx = camera.cy = (side - 1) / 2.0;
  from.camera_from_object = look_at(eye, object.centre, back.unitOrthogonal());
  return from;
}

}  // namespace

SplatEyes splat_eyes(const BoundingSphere& object, std::span<const PosedCamera> images, double splat_width) {
  std::vector<Vector3d> image_eyes;
  std::vector<double> distances, pitches;
  for (const PosedCamera& image : images) {
    image_eyes.push_back(camera_centre(image.camera_from_object));
    distances.push_back((image_eyes.back() - object.centre).norm());
    pitches.push_back(distances.back() / image.camera.fx);
  }
  double distance = kDistance * object.radius, pitch = splat_width / std::sqrt(kPixelsPerSplat);
  if (!images.empty()) {
    distance = std::max(kLeastDistance * object.radius, median(distances));
    pitch = std::max(pitch, median(pitches));
  }
  SplatEyes eyes;
  for (std::size_t i = 0; i < kNear && !images.empty(); ++i)
    eyes.near.push_back(camera_at(eye_between(image_eyes, i), object, pitch));
  for (std::size_t i = 0; i < kRound; ++i)
    eyes.round.push_back(camera_at(object.centre + distance * direction_round(i), object, pitch));
  for (std::size_t i = 0; i < kCheck && !images.empty(); ++i)
    eyes.check.push_back(camera_at(eye_between(image_eyes, kNear + i), object, pitch));
  if (images.empty()) eyes.check = eyes.round;
  return eyes;
}

}  // namespace sheen
