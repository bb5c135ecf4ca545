// SPDX-License-Identifier: Apache-2.0
#include "tests/loopback/ball_dataset.h"

#include <cmath>
#include <fstream>
#include <string>

#include "common/camera/camera.h"
#include "common/datasets/dataset.h"
#include "common/geometry/mesh.h"
#include "common/image/image_io.h"
#include "tests/support/test_meshes.h"

namespace sheen::testing {
namespace {

constexpr double kRadius = 0.05;

/// sRGB levels of the ball's point `n` (unit) seen along `d`: a pattern, and a highlight that moves with the view.
Eigen::Vector3d shade(const Eigen::Vector3d& n, const Eigen::Vector3d& d) {
  const Eigen::Vector3d light = Eigen::Vector3d(1, 2, 3).normalized();
  const double gloss = std::pow(std::max(0.0, (d - 2 * d.dot(n) * n).dot(light)), 20);
  const Eigen::Vector3d pattern(std::sin(20 * n.x()), std::sin(25 * n.y()), std::sin(30 * n.z()));
  return (Eigen::Vector3d(110, 100, 90) + 40 * pattern).array() + 80 * gloss;
}

struct Picture {
  ImageU8 image, mask;
};

Picture draw(const Camera& camera, const Rigid3& camera_from_object) {
  Picture p{ImageU8(camera.width, camera.height, 3, 20), ImageU8(camera.width, camera.height, 1, 0)};
  const Eigen::Vector3d eye = camera_centre(camera_from_object);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d in_camera((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const Eigen::Vector3d d = camera_from_object.rotation.conjugate() * in_camera.normalized();
      const double along = -eye.dot(d), miss = eye.squaredNorm() - along * along;
      if (miss > kRadius * kRadius) continue;
      const Eigen::Vector3d n = (eye + (along - std::sqrt(kRadius * kRadius - miss)) * d) / kRadius;
      const Eigen::Vector3d colour = shade(n, d);
      for (int c = 0; c < 3; ++c) p.image.at(x, y, c) = static_cast<std::uint8_t>(std::lround(colour[c]));
      p.mask.at(x, y) = 255;
    }
  return p;
}

}  // namespace

void BallDataset::write() const {
  std::filesystem::create_directories(folder / "images");
  std::filesystem::create_directories(folder / "masks");
  save_ply(sphere_mesh(static_cast<float>(kRadius), 2), mesh());
  const Camera camera{.width = width,
                      .height = height,
                      .fx = 1.2 * width,
                      .fy = 1.2 * width,
                      .cx = (width - 1) / 2.0,
                      .cy = (height - 1) / 2.0};
  std::vector<DatasetView> all;
  for (int i = 0; i < views; ++i) {
    const double turn = 2.4 * i, height_angle = 0.2 + 1.1 * (i % 7) / 7;
    const Eigen::Vector3d eye = 0.2 * Eigen::Vector3d(std::cos(turn) * std::cos(height_angle),
                                                      std::sin(turn) * std::cos(height_angle), std::sin(height_angle));
    const std::string name = "images/" + std::to_string(1000 + i) + ".png";
    all.push_back({.name = name,
                   .image_path = folder / name,
                   .mask_path = folder / "masks" / (std::to_string(1000 + i) + ".png"),
                   .camera = camera,
                   .camera_from_object = look_at(eye, {0, 0, 0}, {0, 0, 1}),
                   .purpose = i % 8 == 4 ? Purpose::kHeldOut : Purpose::kTraining});
    const Picture picture = draw(camera, all.back().camera_from_object);
    write_png(all.back().image_path, picture.image);
    write_png(*all.back().mask_path, picture.mask);
  }
  std::ofstream(scene()) << "[surface_light_field]\nsurface_map = 4\nmax_rank = 4\n";
  write_transforms(folder / "transforms.json", all);
}

}  // namespace sheen::testing
