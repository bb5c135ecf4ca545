// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "common/base/angle.h"
#include "common/capture/capture.h"
#include "reconstructor/models/irradiance_field/irradiance_field.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"

namespace sheen {

/// A matt, coloured relief under one far light: radiance is albedo times N.L, no shadows. All lights are above all of
/// its tangent planes.
struct LambertianRelief {
  int width = 70, height = 45;  // no whole number of tiles
  double tilt = 0.12;           // radians: of the steepest slope

  Eigen::Vector3d normal(int x, int y) const {
    return Eigen::Vector3d(tilt * std::sin(0.21 * x + 0.05 * y), tilt * std::cos(0.17 * y), 1).normalized();
  }
  Eigen::Vector3f albedo(int x, int y) const {
    return {0.3f + 0.2f * std::sin(0.3f * static_cast<float>(x)), 0.5f, x / 20 % 2 == y / 20 % 2 ? 0.7f : 0.2f};
  }
  ImageF picture(const Eigen::Vector3d& light) const {
    ImageF image(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        Eigen::Map<Eigen::Vector3f>(image.pixel(x, y)) =
            albedo(x, y) * static_cast<float>(std::max(0.0, normal(x, y).dot(light.normalized())));
    return image;
  }
  PosedCamera camera() const {
    PosedCamera posed;
    posed.camera = {
        .width = width, .height = height, .fx = 80, .fy = 80, .cx = (width - 1) / 2.0, .cy = (height - 1) / 2.0};
    posed.camera_from_object = {Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 1}};
    return posed;
  }
  Capture capture(const Eigen::Vector3d& light, std::uint64_t sequence) const {
    const ImageF linear = picture(light);
    Capture capture;
    capture.source_session = "relief";
    capture.sequence = sequence;
    capture.camera = camera().camera;
    capture.image = {.format = PixelFormat::kRGB32f,
                     .transfer = Transfer::kLinear,
                     .width = width,
                     .height = height,
                     .stride = 12 * static_cast<std::size_t>(width),
                     .bytes = std::vector<std::uint8_t>(linear.size() * sizeof(float))};
    std::memcpy(capture.image.bytes.data(), linear.data(), capture.image.bytes.size());
    capture.pose.status = PoseStatus::kGiven;
    capture.pose.camera_from_object = camera().camera_from_object;
    capture.light = {.kind = LightKind::kDirectional, .position = light.normalized()};
    return capture;
  }
  std::unique_ptr<IrradianceField> model(const std::vector<Eigen::Vector3d>& lights) const {
    auto model = std::make_unique<IrradianceField>(std::make_shared<const Mesh>(picture_plane(camera())),
                                                   IrradianceFieldOptions());
    for (std::size_t i = 0; i < lights.size(); ++i) model->ingest(capture(lights[i], i + 1));
    return model;
  }
};

/// Rings of lights from 20 degrees above the horizon up to the zenith.
inline std::vector<Eigen::Vector3d> dome_of_lights(double shift_deg = 0) {
  std::vector<Eigen::Vector3d> lights;
  for (const auto& [elevation, count] : {std::pair{20, 16}, {40, 12}, {60, 8}, {77, 5}, {90, 1}})
    for (int i = 0; i < count; ++i) {
      const double azimuth = (360.0 * i / count + elevation + shift_deg) * kDegree, e = elevation * kDegree;
      lights.emplace_back(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e));
    }
  return lights;
}

}  // namespace sheen
