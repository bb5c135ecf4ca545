// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/projection_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>

namespace sheen {
namespace {

constexpr int kColumns = 33, kRows = 25;  // odd: one stands in the middle
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kRotationSteps = 10;

ImageMap empty_map(const Camera& camera) {
  return {camera.width, camera.height, kColumns, kRows, std::vector<double>(kColumns * kRows, kNone)};
}

/// A point of the grid: its ray and how its pixel moves.
struct Place {
  Eigen::Vector3d ray;
  PixelDerivative derivative;
  bool fits_rotation = false;
};

std::vector<std::optional<Place>> places_of(const Camera& camera) {
  const ImageMap map = empty_map(camera);
  const Eigen::Vector2d middle((camera.width - 1) / 2.0, (camera.height - 1) / 2.0);
  const double radius = std::min(camera.width, camera.height) / 2.0;
  std::vector<std::optional<Place>> places;
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const Eigen::Vector2d pixel = map.pixel(column, row);
      const auto ray = camera.ray(pixel);
      places.emplace_back();
      if (ray) places.back() = Place{*ray, pixel_derivative(camera, *ray), (pixel - middle).norm() <= radius};
    }
  return places;
}

/// (sum of W^T W)^-1, W the derivative by a rotation.
Eigen::Matrix3d rotation_solver(const std::vector<std::optional<Place>>& places) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& place : places)
    if (place && place->fits_rotation) sum += place->derivative.rotation.transpose() * place->derivative.rotation;
  return sum.ldlt().solve(Eigen::Matrix3d::Identity());
}

ImageMap lengths(const Camera& camera, const std::vector<Eigen::Vector2d>& vectors) {
  ImageMap map = empty_map(camera);
  for (std::size_t i = 0; i < vectors.size(); ++i) map.values[i] = vectors[i].norm();
  return map;
}

}  // namespace

Eigen::Vector2d ImageMap::pixel(int column, int row) const {
  return {double(column) * (width - 1) / (columns - 1), double(row) * (height - 1) / (rows - 1)};
}

double ImageMap::rms() const {
  double sum = 0;
  int count = 0;
  for (const double value : values)
    if (std::isfinite(value)) {
      sum += value * value;
      ++count;
    }
  return count > 0 ? std::sqrt(sum / count) : kNone;
}

double ImageMap::worst() const {
  double most = kNone;
  for (const double value : values)
    if (std::isfinite(value) && !(value <= most)) most = value;
  return most;
}

Eigen::Vector2d ImageMap::worst_pixel() const {
  const double most = worst();
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (at(column, row) == most) return pixel(column, row);
  return {kNone, kNone};
}

int ImageMap::missing() const {
  int count = 0;
  for (const double value : values) count += !std::isfinite(value);
  return count;
}

std::vector<Eigen::Matrix2d> projection_covariance(const Camera& camera, const IntrinsicsCovariance& covariance) {
  const auto places = places_of(camera);
  Eigen::Matrix<double, 3, kIntrinsics> pull = Eigen::Matrix<double, 3, kIntrinsics>::Zero();  // W^T I, summed
  for (const auto& place : places)
    if (place && place->fits_rotation) pull += place->derivative.rotation.transpose() * place->derivative.intrinsics;
  const Eigen::Matrix<double, 3, kIntrinsics> turn = -(rotation_solver(places) * pull);
  std::vector<Eigen::Matrix2d> result;
  for (const auto& place : places) {
    if (!place) {
      result.push_back(Eigen::Matrix2d::Constant(kNone));
      continue;
    }
    const Eigen::Matrix<double, 2, kIntrinsics> left = place->derivative.intrinsics + place->derivative.rotation * turn;
    result.push_back(left * covariance * left.transpose());
  }
  return result;
}

ImageMap projection_uncertainty(const Camera& camera, const IntrinsicsCovariance& covariance) {
  ImageMap map = empty_map(camera);
  const auto covariances = projection_covariance(camera, covariance);
  for (std::size_t i = 0; i < covariances.size(); ++i) map.values[i] = std::sqrt(covariances[i].trace());
  return map;
}

std::vector<Eigen::Vector2d> projection_shift(const Camera& camera, const Camera& other) {
  const auto places = places_of(camera);
  const ImageMap map = empty_map(camera);
  const Eigen::Matrix3d solver = rotation_solver(places);
  Eigen::Matrix3d other_from_camera = Eigen::Matrix3d::Identity();
  const auto shift = [&](std::size_t i) -> Eigen::Vector2d {
    if (!places[i]) return {kNone, kNone};
    const auto pixel = other.project(other_from_camera * places[i]->ray);
    if (!pixel) return {kNone, kNone};
    return *pixel - map.pixel(static_cast<int>(i) % map.columns, static_cast<int>(i) / map.columns);
  };
  for (int step = 0; step < kRotationSteps; ++step) {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!places[i] || !places[i]->fits_rotation) continue;
      if (const Eigen::Vector2d error = shift(i); error.allFinite())
        pull += places[i]->derivative.rotation.transpose() * error;
    }
    const Eigen::Vector3d turn = -(solver * pull);
    if (!(turn.norm() > 1e-14)) break;
    other_from_camera = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * other_from_camera;
  }
  std::vector<Eigen::Vector2d> shifts;
  for (std::size_t i = 0; i < places.size(); ++i) shifts.push_back(shift(i));
  return shifts;
}

ImageMap projection_difference(const Camera& camera, const Camera& other) {
  return lengths(camera, projection_shift(camera, other));
}

}  // namespace sheen
