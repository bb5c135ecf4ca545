// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_rig.h"

#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/errors.h"

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kEyeDistance = 1.0, kEyeElevation = 52, kStep = 0.02;  // metres, degrees
constexpr double kFieldOfView = 36;                                     // degrees across
constexpr double kLampDistance = 1.3, kLampElevation = 50;
constexpr float kOffset = 2e-5f;  // metres, clears the triangle that a shadow ray starts on
constexpr int kEdgeSide = 4;      // samples along a side of a pixel that an edge crosses
constexpr float kLobeExponent = 40;

/// `azimuth`: 0 at the right of the scene, pi at its left, the far side between.
LightState lamp_at(double azimuth) {
  const double up = kLampElevation * kDegree;
  return {.kind = LightKind::kPoint,
          .position = kLampDistance *
                      Vector3d(std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up))};
}

}  // namespace

LightRig::LightRig(const LightRigOptions& options)
    : options_(options), scene_(make_toy_scene(static_cast<float>(options.gloss))) {
  if (options.lights < 2 || options.lights > 99) throw ConfigError("simulation: a light rig has 2 to 99 lights");
  if (options.columns < 1 || options.rows < 1 || options.columns > 99 || options.rows > 99)
    throw ConfigError("simulation: the grid of cameras must be 1x1 to 99x99");
  if (options.width < 16 || options.height < 16 || options.width > 8192 || options.height > 8192)
    throw ConfigError("simulation: the size must be 16x16 to 8192x8192 pixels");
  if (!(options.gloss >= 0 && options.gloss <= 1)) throw ConfigError("simulation: gloss must be 0 to 1");
  rays_ = std::make_unique<RayScene>(scene_.mesh);
  for (int row = 0; row < options.rows; ++row)
    for (int column = 0; column < options.columns; ++column) cameras_.push_back(camera_at(column, row));
  for (int i = 0; i < options.lights; ++i) {
    lights_.push_back(light_at(i));
    if (i + 1 < options.lights) midway_lights_.push_back(light_at(i + 0.5));
  }
}

LightState LightRig::light_at(double place) const {
  return lamp_at(place * M_PI / (options_.lights - 1));
}

PosedCamera LightRig::camera_at(double column, double row) const {
  const double focal = options_.width / 2.0 / std::tan(kFieldOfView / 2 * kDegree);
  const Camera camera{.width = options_.width,
                      .height = options_.height,
                      .fx = focal,
                      .fy = focal,
                      .cx = (options_.width - 1) / 2.0,
                      .cy = (options_.height - 1) / 2.0};
  const double up = kEyeElevation * kDegree;
  const Vector3d target(0, 0, 0.02), eye = target + kEyeDistance * Vector3d(0, -std::cos(up), std::sin(up));
  const Rigid3 centre = look_at(eye, target, Vector3d::UnitZ());
  const Vector3d moved((column - (options_.columns - 1) / 2.0) * kStep, (row - (options_.rows - 1) / 2.0) * kStep, 0);
  return {camera, {centre.rotation, centre.translation - moved}};
}

/// What one ray sees.
struct LightRig::Seen {
  Hit hit;
  bool lit = false;
  Vector3f position = Vector3f::Zero();
  Array3f radiance = Array3f::Zero(), albedo = Array3f::Zero();

  bool same(const Seen& other, const std::vector<std::uint8_t>& parts) const {
    return bool(hit) == bool(other.hit) && (!hit || (parts[hit.triangle] == parts[other.hit.triangle])) &&
           lit == other.lit;
  }
};

LightRig::Seen LightRig::look(const Ray& ray, const LightState& light) const {
  Seen seen{.hit = rays_->intersect(ray)};
  if (!seen.hit) return seen;
  const std::size_t corner = 3 * std::size_t(seen.hit.triangle);
  const Vector3f normal = ((1 - seen.hit.u - seen.hit.v) * scene_.normals[corner] +
                           seen.hit.u * scene_.normals[corner + 1] + seen.hit.v * scene_.normals[corner + 2])
                              .normalized(),
                 flat = scene_.mesh.area_normal(seen.hit.triangle).normalized();
  seen.position = ray.origin + seen.hit.distance * ray.direction;
  const Vector3f to_lamp = light.position.cast<float>() - seen.position;
  const float distance = to_lamp.norm(), cosine = normal.dot(to_lamp) / distance;
  // A facet of a round solid may face the lamp where the solid does not, or the other way round: both must.
  seen.lit = cosine > 0 && flat.dot(to_lamp) > 0 && !rays_->occluded({seen.position + kOffset * flat, to_lamp, 0, 1});
  const std::uint8_t part = scene_.parts[seen.hit.triangle];
  seen.albedo = scene_.albedo(part, seen.position);
  const float falloff = static_cast<float>(kLampDistance * kLampDistance) / (distance * distance);
  seen.radiance = seen.albedo * static_cast<float>(kAmbient);
  if (!seen.lit) return seen;
  seen.radiance += seen.albedo * cosine * falloff * light.rgb.array();
  if (scene_.gloss > 0 && part != ToyScene::kGround && part != ToyScene::kBox) {
    const Vector3f half = (to_lamp / distance - ray.direction.normalized()).normalized();
    seen.radiance +=
        scene_.gloss * std::pow(std::max(0.0f, normal.dot(half)), kLobeExponent) * falloff * light.rgb.array();
  }
  return seen;
}

SimulatedPicture LightRig::picture(const PosedCamera& from, const LightState& light) const {
  const int w = from.camera.width, h = from.camera.height;
  const Rigid3 object_from_camera = from.camera_from_object.inverse();
  const Eigen::Matrix3f rotation = object_from_camera.rotation.toRotationMatrix().cast<float>();
  const Vector3f eye = object_from_camera.translation.cast<float>();
  const auto ray_at = [&](double x, double y) {
    return Ray{
        eye,
        rotation *
            Vector3d((x - from.camera.cx) / from.camera.fx, (y - from.camera.cy) / from.camera.fy, 1).cast<float>()};
  };
  SimulatedPicture out{ImageF(w, h, 3), ImageF(w, h, 1), ImageU8(w, h, 1), ImageF(w, h, 3)};
  tbb::parallel_for(tbb::blocked_range<int>(0, h, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<Seen> above(w + 1), below(w + 1);
    const auto corners = [&](int y, std::vector<Seen>& seen) {
      for (int x = 0; x <= w; ++x) seen[x] = look(ray_at(x - 0.5, y - 0.5), light);
    };
    corners(rows.begin(), below);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      std::swap(above, below);
      corners(y + 1, below);
      for (int x = 0; x < w; ++x) {
        const Seen middle = look(ray_at(x, y), light);
        out.depth.at(x, y) = middle.hit ? middle.hit.distance : 0;  // rays have z = 1
        out.shadow.at(x, y) = middle.lit ? 0 : 255;
        Array3f::Map(out.reflectance.pixel(x, y)) = middle.albedo;
        const bool uniform = middle.same(above[x], scene_.parts) && middle.same(above[x + 1], scene_.parts) &&
                             middle.same(below[x], scene_.parts) && middle.same(below[x + 1], scene_.parts);
        Array3f sum = Array3f::Zero();
        const int side = uniform ? 1 : kEdgeSide;
        for (int k = 0; k < side * side; ++k)
          sum +=
              uniform
                  ? middle.radiance
                  : look(ray_at(x - 0.5 + (k % side + 0.5) / side, y - 0.5 + (k / side + 0.5) / side), light).radiance;
        Array3f::Map(out.radiance.pixel(x, y)) = sum / float(side * side);
      }
    }
  });
  return out;
}

}  // namespace sheen
