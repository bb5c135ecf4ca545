// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/patch_steps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/light_field_file/file_layout.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// A square under one camera; what lies left has lattices of 14 samples, what lies right some of 3.
CompactModel square_under_a_camera() {
  CompactModel model;
  model.mesh = std::make_shared<Mesh>(square_mesh(0.1f, 0, 8));
  GridMesh grid{.triangles = model.mesh->triangles};
  for (const Eigen::Vector3f& vertex : model.mesh->vertices) {
    const Eigen::Vector3i place = (1e5f * vertex).array().round().cast<int>();
    grid.points.push_back({place.x(), place.y(), place.z()});
  }
  model.grid = std::make_shared<GridMesh>(std::move(grid));
  std::vector<std::uint8_t> resolutions;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t)
    resolutions.push_back(
        model.mesh->corner(t, 0).x() + model.mesh->corner(t, 1).x() + model.mesh->corner(t, 2).x() < 0 ? 14 : 3);
  model.maps = std::make_shared<MapLayout>(resolutions);
  PosedCamera camera{.camera = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240}};
  camera.camera_from_object.rotation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());  // from above
  camera.camera_from_object.translation.z() = 3;
  model.cameras = {camera};
  model.vertices.assign(model.mesh->vertices.size(), {.seen = true, .views = {{.image = 0}}});
  find_sources(model);
  model.patch_triangles = 4;
  model.shapes = cut_into_patches(*model.mesh, *model.maps, {.triangles = 4});
  return model;
}

TEST(PatchSteps, AreFinerWhereASampleHasMorePixels) {
  const CompactModel model = square_under_a_camera();
  const std::vector<std::int8_t> steps = choose_patch_steps(model, one_after_the_other);
  ASSERT_EQ(steps.size(), model.shapes.patches.size());
  for (std::size_t p = 0; p < steps.size(); ++p) {
    const double samples_per_triangle = static_cast<double>(model.shapes.patches[p].samples) /
                                        static_cast<double>(model.shapes.patches[p].triangles.size());
    if (samples_per_triangle == 105) EXPECT_NEAR(steps[p], 0, 1) << "most samples are in such: they are the mean";
    if (samples_per_triangle == 6) EXPECT_LE(steps[p], -4);
  }
  EXPECT_LT(step_of_patch(2, -4), 2);
  EXPECT_FLOAT_EQ(step_of_patch(2, 4), 4);
}

TEST(PatchSteps, WithoutImagesAllAreTheModels) {
  CompactModel model = square_under_a_camera();
  for (CompactVertex& vertex : model.vertices) vertex = {};
  find_sources(model);
  EXPECT_EQ(choose_patch_steps(model, one_after_the_other), std::vector<std::int8_t>(model.shapes.patches.size(), 0));
}

}  // namespace
}  // namespace sheen
