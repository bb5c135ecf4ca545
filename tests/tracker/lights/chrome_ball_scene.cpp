// SPDX-License-Identifier: Apache-2.0
#include "tests/tracker/lights/chrome_ball_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "common/base/angle.h"
#include "common/image/color.h"

namespace sheen {
namespace {

constexpr int kSamples = 4;

/// What a ray that left the ball meets: a room with stripes that stand still, and the lamps. Axes of a list of lights.
float surroundings(const Eigen::Vector3d& way, const std::vector<FarLamp>& lamps) {
  float light = way.y() > 0 ? 0.06f : 0.03f;
  if (std::fmod(std::atan2(way.x(), way.z()) / kDegree + 360, 40) < 12) light += 0.05f;
  for (const FarLamp& lamp : lamps)
    if (way.dot(lamp.towards) > std::cos(lamp.radius_deg * kDegree)) light += lamp.radiance;
  return light;
}

/// A table with boards, a grid of lines and coins of the ball's size, lit by the lamps.
float table(double x, double y, const std::vector<FarLamp>& lamps) {
  float albedo = 0.25f;
  if (std::fmod(x + 2 * y + 90, 90) < 30) albedo = 0.4f;
  if (std::fmod(x, 37) < 2 || std::fmod(y, 53) < 2) albedo = 0.1f;
  if (std::hypot(x - 90, y - 80) < 40) albedo = std::hypot(x - 90, y - 80) < 30 ? 0.5f : 0.15f;
  if (std::hypot(x - 400, y - 290) < 48) albedo = 0.6f;
  float light = 0.1f;
  for (const FarLamp& lamp : lamps)
    light += std::max(0.0f, static_cast<float>(lamp.towards.z())) * (y > 200 && lamp.towards.x() > 0 ? 0.3f : 0.8f);
  return albedo * light;
}

/// Where the ray through a pixel goes after the ball; empty: it misses.
std::optional<Eigen::Vector3d> mirrored(const ChromeBallScene& scene, double x, double y) {
  Eigen::Vector3d ray(0, 0, 1), from;  // radii, the ball's centre is the origin
  if (scene.camera) {
    ray = scene.camera->ray({x, y}).value();
    from = -scene.place;
  } else {
    from = {(x - scene.centre.x()) / scene.radius, (y - scene.centre.y()) / scene.radius, -10};
  }
  const double b = ray.dot(from), c = from.squaredNorm() - 1, inside = b * b - c;
  if (inside <= 0) return std::nullopt;
  const Eigen::Vector3d normal = from + (-b - std::sqrt(inside)) * ray;
  const Eigen::Vector3d out = ray - 2 * ray.dot(normal) * normal;
  return Eigen::Vector3d(out.x(), -out.y(), -out.z());
}

/// Whether some ray of a pixel may meet the ball: saves time.
bool near_the_ball(const ChromeBallScene& scene, double x, double y) {
  if (!scene.camera) return std::hypot(x - scene.centre.x(), y - scene.centre.y()) < scene.radius + 2;
  const double reach = std::asin(1 / scene.place.norm()) / kDegree + 2;
  return angle_deg(scene.camera->ray({x, y}).value(), scene.place) < reach;
}

/// As a lens does: by a Gaussian of 0.6 pixels.
float blurred(const ImageF& sharp, int x, int y) {
  constexpr std::array kWeights{0.6649f, 0.1658f, 0.0026f};  // of distances 0, 1, 2
  float sum = 0, weights = 0;
  for (int v = std::max(0, y - 2); v <= std::min(sharp.height() - 1, y + 2); ++v)
    for (int u = std::max(0, x - 2); u <= std::min(sharp.width() - 1, x + 2); ++u) {
      const float weight = kWeights[std::size_t(std::abs(u - x))] * kWeights[std::size_t(std::abs(v - y))];
      sum += weight * sharp.at(u, v);
      weights += weight;
    }
  return sum / weights;
}

}  // namespace

ImageF ChromeBallScene::image(const std::vector<FarLamp>& lamps, unsigned seed) const {
  ImageF sharp(width, height, 1), image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float& light = sharp.at(x, y);
      const bool near = ball && near_the_ball(*this, x, y);
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double sx = x + (k % kSamples + 0.5) / kSamples - 0.5, sy = y + (k / kSamples + 0.5) / kSamples - 0.5;
        const auto way = near ? mirrored(*this, sx, sy) : std::nullopt;
        light += (way ? surroundings(*way, lamps) : table(sx, sy, lamps)) / (kSamples * kSamples);
      }
    }
  std::mt19937 random(seed);
  std::normal_distribution<double> grain(0, noise);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double grey = 255 * double(srgb_encode(std::min(blurred(sharp, x, y), 1.0f))) + grain(random);
      image.at(x, y) = srgb_decode(static_cast<float>(std::clamp(std::round(grey), 0.0, 255.0) / 255));
    }
  return image;
}

std::vector<FarLamp> lamps_on_dome(int count, double lowest_deg) {
  std::vector<FarLamp> lamps;
  const double lowest = std::sin(lowest_deg * kDegree);
  for (int i = 0; i < count; ++i) {
    const double z = lowest + (1 - lowest) * (i + 0.5) / count, azimuth = 2.4 * i + 0.3, flat = std::sqrt(1 - z * z);
    lamps.push_back({.towards = {flat * std::cos(azimuth), flat * std::sin(azimuth), z}});
  }
  return lamps;
}

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

}  // namespace sheen
