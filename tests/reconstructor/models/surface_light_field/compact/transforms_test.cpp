// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "reconstructor/light_field_file/lattice_spectrum.h"
#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/light_field_file/view_haar.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

TEST(LatticeSpectrum, HoldsEachSampleOnceAndIsOrthonormal) {
  for (const int resolution : {2, 3, 8, 24, 25, 40, 97}) {
    std::set<int> samples;
    for (const LatticeSpectrum::Tile& tile : lattice_spectrum(resolution).tiles) {
      samples.insert(tile.samples.begin(), tile.samples.end());
      const Eigen::MatrixXf& vectors = *tile.vectors;
      ASSERT_EQ(vectors.rows(), static_cast<Eigen::Index>(tile.samples.size()));
      EXPECT_TRUE((vectors.transpose() * vectors).isIdentity(1e-4f)) << resolution;
      const float level = vectors(0, 0);
      EXPECT_TRUE(vectors.col(0).isConstant(level, 1e-4f)) << "the smoothest is constant: " << resolution;
      EXPECT_GT(level, 0);
    }
    EXPECT_EQ(samples.size(), static_cast<std::size_t>(lattice_samples(resolution)));
    EXPECT_EQ(*samples.rbegin(), lattice_samples(resolution) - 1);
  }
}

/// The lattice's graph once more, as docs/model_format.md describes it: samples (i, j) of a tile in their order.
struct Lattice {
  int rows, columns, diagonal;
  auto operator<=>(const Lattice&) const = default;

  Eigen::MatrixXd laplacian() const {
    std::map<std::pair<int, int>, Eigen::Index> at;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns && i + j < diagonal; ++j)
        at.emplace(std::pair(i, j), static_cast<Eigen::Index>(at.size()));
    Eigen::MatrixXd sum =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(at.size()), static_cast<Eigen::Index>(at.size()));
    for (const auto& [from, a] : at) {
      const auto [i, j] = from;
      const std::pair<int, int> ends[] = {{i + 1, j}, {i, j + 1}, {i + 1, j - 1}};
      const int base[] = {10000, 10500, 9600};
      for (int d = 0; d < 3; ++d) {
        if (!at.contains(ends[d])) continue;
        const double weight = (base[d] + 10 * ((3 * i + 91 * j + 78 * d) % 101 - 50)) / 10000.0;
        Eigen::VectorXd edge = Eigen::VectorXd::Unit(sum.rows(), a) - Eigen::VectorXd::Unit(sum.rows(), at[ends[d]]);
        sum.selfadjointView<Eigen::Lower>().rankUpdate(edge, weight);
      }
    }
    return sum.selfadjointView<Eigen::Lower>();
  }
};

/// The tiles of a triangle's lattice.
std::vector<Lattice> tiles_of(int resolution) {
  std::vector<Lattice> tiles;
  const int parts = resolution <= 24 ? 1 : (resolution + 15) / 16, side = (resolution + parts - 1) / parts;
  for (int top = 0; top < resolution; top += side)
    for (int left = 0; top + left < resolution; left += side)
      tiles.push_back({std::min(side, resolution - top), std::min(side, resolution - left),
                       std::min(resolution - top - left, 2 * side)});
  return tiles;
}

// Another solver finds the same eigenvectors with the same signs: what a file holds does not depend on how a reader
// rounds.
TEST(LatticeSpectrum, IsThatOfAnotherImplementation) {
  for (const int resolution : {2, 3, 7, 16, 24, 32, 97}) {
    const std::vector<Lattice> tiles = tiles_of(resolution);
    const LatticeSpectrum& spectrum = lattice_spectrum(resolution);
    ASSERT_EQ(spectrum.tiles.size(), tiles.size());
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      Eigen::MatrixXd vectors = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(tiles[t].laplacian()).eigenvectors();
      Eigen::VectorXd sign(vectors.rows());
      for (Eigen::Index a = 0; a < sign.size(); ++a)
        sign[a] = static_cast<std::uint32_t>(static_cast<std::uint32_t>(a) * 2654435761u) / 4294967296.0;
      for (Eigen::Index f = 0; f < vectors.cols(); ++f)
        if (sign.dot(vectors.col(f)) < 0) vectors.col(f) *= -1;
      EXPECT_LT((vectors.cast<float>() - *spectrum.tiles[t].vectors).cwiseAbs().maxCoeff(), 1e-6f) << resolution;
    }
  }
}

TEST(LatticeSpectrum, NoTwoEigenvaluesOfAnyLatticeAreNearEachOther) {
  std::set<Lattice> lattices;
  for (int resolution = 2; resolution <= 255; ++resolution)
    for (const Lattice& tile : tiles_of(resolution)) lattices.insert(tile);
  EXPECT_GT(lattices.size(), 100u);
  for (const Lattice& lattice : lattices) {
    const Eigen::MatrixXd laplacian = lattice.laplacian();
    if (laplacian.rows() < 2) continue;
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(laplacian, Eigen::EigenvaluesOnly).eigenvalues();
    const Eigen::Index n = values.size() - 1;
    EXPECT_GT((values.tail(n) - values.head(n)).minCoeff(), 5e-4)
        << lattice.rows << " x " << lattice.columns << ", " << lattice.diagonal;
  }
}

std::vector<GridMesh::Point> eyes_round(std::size_t count) {
  std::vector<GridMesh::Point> eyes(count);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1e5);
  for (GridMesh::Point& eye : eyes)
    for (std::int32_t& entry : eye) entry = static_cast<std::int32_t>(normal(random));
  return eyes;
}

TEST(ViewHaar, IsOrthonormalOverEverySubset) {
  std::mt19937 random(4);
  const ViewHaar haar(eyes_round(50), {0, 0, 0});
  for (const std::size_t keep : {1, 2, 3, 10, 50}) {
    std::vector<std::uint16_t> images;
    for (std::uint16_t i = 0; i < 50; ++i)
      if (images.size() < keep && random() % 2) images.push_back(i);
    if (images.empty()) images.push_back(7);
    const ViewHaar::Plan plan = haar.plan(images);
    const auto n = static_cast<Eigen::Index>(images.size());
    Eigen::MatrixXf transform(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXf unit = Eigen::VectorXf::Unit(n, j);
      ViewHaar::forward(plan, unit);
      transform.col(j) = unit;
      ViewHaar::inverse(plan, unit);
      EXPECT_TRUE(unit.isApprox(Eigen::VectorXf::Unit(n, j), 1e-5f));
    }
    EXPECT_TRUE((transform.transpose() * transform).isIdentity(1e-5f)) << n;
    Eigen::VectorXf same = Eigen::VectorXf::Ones(n);
    ViewHaar::forward(plan, same);
    EXPECT_NEAR(same[0], std::sqrt(static_cast<float>(n)), 1e-4f);
    EXPECT_LT(same.tail(n - 1).norm(), 1e-4f) << "what is the same in all images is one number";
  }
}

TEST(PatchShapes, EachTriangleIsInOnePatch) {
  const Mesh mesh = sphere_mesh(1, 3);
  const MapLayout maps(std::vector<std::uint8_t>(mesh.triangles.size(), 5));
  for (const std::size_t most : {1, 4, 8, 30}) {
    const PatchShapes shapes = cut_into_patches(mesh, maps, {.triangles = most});
    std::size_t triangles = 0;
    for (std::size_t p = 0; p < shapes.patches.size(); ++p) {
      const PatchShape& patch = shapes.patches[p];
      EXPECT_LE(patch.triangles.size(), most + most / 2 + 1) << "what is left over goes to a neighbour";
      EXPECT_EQ(patch.samples, patch.triangles.size() * static_cast<std::size_t>(lattice_samples(5)));
      std::uint32_t before = 0;
      for (const std::uint32_t t : patch.triangles) {
        EXPECT_EQ(shapes.patch_of[t], p);
        EXPECT_EQ(shapes.first_sample[t], before);
        before += static_cast<std::uint32_t>(lattice_samples(5));
      }
      triangles += patch.triangles.size();
    }
    EXPECT_EQ(triangles, mesh.triangles.size());
    EXPECT_LT(shapes.patches.size(), 2 * mesh.triangles.size() / most + 1);
  }
}

TEST(PatchShapes, PatchesOfFineTrianglesHaveMoreOfThem) {
  const Mesh mesh = sphere_mesh(1, 4);
  const auto is_fine = [&](std::uint32_t t) { return mesh.corner(t, 0).z() > 0; };
  std::vector<std::uint8_t> resolution;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) resolution.push_back(is_fine(t) ? 4 : 12);
  const MapLayout maps(resolution);  // 10 samples and 78
  const PatchShapes shapes = cut_into_patches(mesh, maps, {.triangles = 2, .samples = 64});
  std::size_t fine = 0, fine_triangles = 0, coarse = 0, coarse_triangles = 0;
  for (const PatchShape& patch : shapes.patches) {
    EXPECT_GE(patch.samples, 16u) << "less than a quarter goes to a neighbour";
    if (std::all_of(patch.triangles.begin(), patch.triangles.end(), is_fine)) {
      ++fine;
      fine_triangles += patch.triangles.size();
      EXPECT_LE(patch.triangles.size(), 9u) << "seven have 70 samples; at most one more is left over beside them";
    } else {
      ++coarse;
      coarse_triangles += patch.triangles.size();
    }
  }
  EXPECT_GT(static_cast<double>(fine_triangles), 5.5 * static_cast<double>(fine));
  EXPECT_LT(static_cast<double>(coarse_triangles), 2.5 * static_cast<double>(coarse));
}

}  // namespace
}  // namespace sheen
