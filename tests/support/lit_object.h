// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "common/simulation/point_lit_scene.h"
#include "common/simulation/test_object.h"
#include "reconstructor/models/irradiance_field/irradiance_field.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"

namespace sheen {

/// The demo's object seen from above, matt and textured or with a gloss (Blinn's lobe), in direct light with shadows:
/// pictures in any light are exact, and an irradiance field is built from some.
struct LitObject {
  PointLitScene scene;

  static PosedCamera camera_above(int width, int height) {
    PosedCamera posed;
    const double focal = 2.2 * height;
    posed.camera = {
        .width = width, .height = height, .fx = focal, .fy = focal, .cx = (width - 1) / 2.0, .cy = (height - 1) / 2.0};
    posed.camera_from_object = {Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 0.5}};
    return posed;
  }
  static LitObject make(int width, int height, float gloss = 0, float exponent = 30) {
    TestObject object = make_demo_object();
    const auto reflect = [gloss, exponent, material = object.material](
                             const Eigen::Vector3f& place, const Eigen::Vector3f& normal, const Eigen::Vector3f& light,
                             const Eigen::Vector3f& eye) -> Eigen::Array3f {
      const float cosine = std::max(0.0f, normal.dot((light + eye).normalized()));
      return (1 - gloss) * material(place).albedo + gloss * std::pow(cosine, exponent);
    };
    return {PointLitScene(object.mesh, object.normals, reflect, camera_above(width, height))};
  }
  /// The field of these lights, of one kind. Its lamps have `rgb`; images are as bright as that makes them.
  std::shared_ptr<const IrradianceFieldSnapshot> field(std::span<const LightState> lights) const {
    IrradianceField model(std::make_shared<const Mesh>(picture_plane(scene.camera())), {});
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const ImageF linear = scene.picture(lights[i]);
      Capture capture;
      capture.source_session = "object";
      capture.sequence = i + 1;
      capture.camera = scene.camera().camera;
      capture.image = {.format = PixelFormat::kRGB32f,
                       .transfer = Transfer::kLinear,
                       .width = linear.width(),
                       .height = linear.height(),
                       .stride = 12 * static_cast<std::size_t>(linear.width()),
                       .bytes = std::vector<std::uint8_t>(linear.size() * sizeof(float))};
      std::memcpy(capture.image.bytes.data(), linear.data(), capture.image.bytes.size());
      capture.pose.status = PoseStatus::kGiven;
      capture.pose.camera_from_object = scene.camera().camera_from_object;
      capture.light = {.kind = lights[i].kind, .position = lights[i].position};
      model.ingest(capture);
    }
    return std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(model.snapshot());
  }
  /// What the scene looks like in all of these lights together.
  ImageF truth(std::span<const LightState> lights) const {
    ImageF sum(scene.camera().camera.width, scene.camera().camera.height, 3);
    for (const LightState& light : lights) {
      const ImageF more = scene.picture(light);
      for (std::size_t i = 0; i < sum.size(); ++i) sum.data()[i] += more.data()[i];
    }
    return sum;
  }
};

/// Far lights on a dome over the object, from 25 degrees above its horizon up; about this far apart.
inline std::vector<LightState> dome_lights(double step_deg) {
  std::vector<LightState> lights;
  constexpr double kDegree = std::numbers::pi / 180;
  for (double elevation = 90; elevation > 24.9; elevation -= step_deg) {
    const double ring = 360 * std::cos(elevation * kDegree);
    const int count = std::max(1, static_cast<int>(std::lround(ring / step_deg)));
    for (int i = 0; i < count; ++i) {
      const double azimuth = 2 * std::numbers::pi * (i + 0.37 * elevation) / count, e = elevation * kDegree;
      lights.push_back({.kind = LightKind::kDirectional,
                        .position = {std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e)}});
    }
  }
  return lights;
}

/// Lamps on a square grid in a plane over the object, as bright as a far light of rgb 1 right below.
inline std::vector<LightState> lamp_grid(int per_side, double spacing, double height) {
  std::vector<LightState> lights;
  for (int i = 0; i < per_side; ++i)
    for (int j = 0; j < per_side; ++j)
      lights.push_back(
          {.kind = LightKind::kPoint,
           .position = {spacing * (i - (per_side - 1) / 2.0), spacing * (j - (per_side - 1) / 2.0), height},
           .rgb = Eigen::Vector3f::Constant(static_cast<float>(height * height))});
  return lights;
}

}  // namespace sheen
