// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/paper_heuristic.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "reconstructor/models/surface_light_field/snapshot.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// Three views close round the normal: a small triangle on the view map, and large ones.
VertexInterpolant three_views(float residual) {
  auto views = std::make_shared<VertexViews>();
  views->frame = hemisphere_frame(Eigen::Vector3f::UnitZ());
  views->directions.resize(3, 3);
  for (int j = 0; j < 3; ++j) {
    const float angle = 2.0f * static_cast<float>(j);
    views->directions.col(j) = Eigen::Vector3f(0.2f * std::cos(angle), 0.2f * std::sin(angle), 1).normalized();
  }
  VertexInterpolant at;
  at.views = std::move(views);
  at.residual = residual;
  return at;
}

/// A square of two triangles, a patch each, whose corners have these residuals; negative: no image showed the patches
/// that have the corner.
std::vector<float> heuristic(const std::array<float, 4>& residuals, const Eigen::Vector3d& eye) {
  const auto mesh = std::make_shared<Mesh>(square_mesh(1e-3f, 0, 1));
  const auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>(2, 2));
  const auto shapes = std::make_shared<const PatchShapes>(cut_into_patches(*mesh, *maps, {.triangles = 1}));
  SurfaceLightFieldSnapshot::Patches data(2);
  for (std::size_t p = 0; p < 2; ++p) {
    auto patch = std::make_shared<PatchSnapshot>();
    patch->basis = Eigen::MatrixXf(Eigen::MatrixXf::Ones(9, 1));
    patch->shown.assign(3, 255);
    bool seen = true;
    for (const std::uint32_t v : shapes->patches[p].vertices) {
      patch->vertices.push_back(three_views(residuals[v]));
      seen &= residuals[v] >= 0;
    }
    if (seen) data[p] = std::move(patch);
  }
  const SurfaceLightFieldSnapshot snapshot(mesh, maps, shapes, data, 1);
  return PaperHeuristic(snapshot).seen_from(eye);
}

/// Of the three views, over what counts as no view near.
float small_area() {
  const VertexInterpolant at = three_views(0);
  const auto point = [&](int j) { return hemisphere_point(at.views->frame, at.views->directions.col(j)); };
  const Eigen::Vector2f u = point(1) - point(0), v = point(2) - point(0);
  return 0.5f * std::abs(u.x() * v.y() - u.y() * v.x()) / 0.25f;
}

TEST(PaperHeuristic, IsTheRootOfTheMeanOfBothSquares) {
  const std::vector<float> above = heuristic({0.15f, 0.15f, 0.15f, 0.15f}, {0, 0, 100});
  ASSERT_EQ(above.size(), 2u);
  EXPECT_NEAR(above[0], std::sqrt(0.5 * (0.6 * 0.6 + small_area() * small_area())), 2e-3)
      << "a quarter of the norm counts as not known at all";
  const std::vector<float> aside = heuristic({0.15f, 0.15f, 0.15f, 0.15f}, {90, 0, 40});
  EXPECT_NEAR(aside[0], std::sqrt(0.5 * (0.6 * 0.6 + 1)), 1e-5) << "no view near";
  EXPECT_NEAR(heuristic({1, 1, 1, 1}, {90, 0, 40})[0], 1, 1e-6);
}

TEST(PaperHeuristic, OfATriangleIsOfTheMeanOfItsVerticesAndOneWithAnUnseenOne) {
  const auto mesh = square_mesh(1e-3f, 0, 1);
  const auto& [a, b, c] = mesh.triangles[0];
  std::array<float, 4> residuals{0, 0, 0, 0};
  residuals[a] = 0.05f;
  residuals[b] = 0.1f;
  residuals[c] = 0.15f;  // 0.2, 0.4, 0.6 of what counts
  EXPECT_NEAR(heuristic(residuals, {90, 0, 40})[0], std::sqrt(0.5 * (0.4 * 0.4 + 1)), 1e-5);
  residuals[b] = -1;
  EXPECT_EQ(heuristic(residuals, {0, 0, 100})[0], 1);
}

}  // namespace
}  // namespace sheen
