// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/closed_surface.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/reconstructor/shape/analytic_field.h"
#include "tests/reconstructor/shape/closed_mesh.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

double ball(const Vector3d& at, const Vector3d& centre, double radius) {
  return (at - centre).norm() - radius;
}
double ring(const Vector3d& at, double large, double small) {
  return std::hypot(std::hypot(at.x(), at.y()) - large, at.z()) - small;
}
double box(const Vector3d& at, const Vector3d& half) {
  return (at.cwiseAbs() - half).maxCoeff();
}

/// What linear interpolation along the longest edges is off by at most on a surface of a radius of curvature, and what
/// the margin adds.
double interpolation_error(double cell, double radius) {
  const double edge = std::sqrt(3) * cell;
  return edge * edge / (8 * radius) + kVertexMargin * edge;
}

template <typename Distance>
double farthest(const Mesh& mesh, const Distance& distance) {
  double most = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    most = std::max(most, std::abs(distance(mesh.origin + vertex.cast<double>())));
  return most;
}

TEST(ClosedSurface, OfABallIsTheSphere) {
  const auto distance = [](const Vector3d& at) { return ball(at, {0.003, -0.002, 0.001}, 0.08); };
  const ClosedSurface surface = closed_surface(field_of(centred_lattice(61, 0.1), 3, distance));
  expect_closed(surface.mesh);
  EXPECT_EQ(euler_characteristic(surface.mesh), 2);
  const double cell = 0.2 / 60, volume = 4.0 / 3 * M_PI * std::pow(0.08, 3);
  EXPECT_LT(farthest(surface.mesh, distance), interpolation_error(cell, 0.08));
  EXPECT_NEAR(diagnose(surface.mesh).signed_volume, volume, 2e-3 * volume);
  EXPECT_EQ(surface.counts.pieces, 1u);
  EXPECT_EQ(surface.counts.cavities, 0u);
  EXPECT_EQ(surface.counts.left_out, 0);
  EXPECT_EQ(surface.forced_outside, 0u);
}

TEST(ClosedSurface, OfARingHasItsHole) {
  const auto distance = [](const Vector3d& at) { return ring(at, 0.6, 0.2); };
  const Mesh mesh = closed_surface(field_of(centred_lattice(70, 1), 4, distance)).mesh;
  expect_closed(mesh);
  EXPECT_EQ(euler_characteristic(mesh), 0);
  EXPECT_LT(farthest(mesh, distance), interpolation_error(2.0 / 69, 0.2));
  const double volume = 2 * M_PI * M_PI * 0.6 * 0.2 * 0.2;
  EXPECT_NEAR(diagnose(mesh).signed_volume, volume, 0.01 * volume);
}

TEST(ClosedSurface, OfTwoBallsThatOverlapIsOnePiece) {
  const double radius = 0.4, apart = 0.5;
  const auto distance = [&](const Vector3d& at) {
    return std::min(ball(at, {-apart / 2, 0, 0}, radius), ball(at, {apart / 2, 0, 0}, radius));
  };
  const Mesh mesh = closed_surface(field_of(centred_lattice(81, 1), 4, distance)).mesh;
  expect_closed(mesh);
  EXPECT_EQ(euler_characteristic(mesh), 2);
  const double lens = M_PI * (4 * radius + apart) * std::pow(2 * radius - apart, 2) / 12;
  const double volume = 2 * 4.0 / 3 * M_PI * std::pow(radius, 3) - lens;
  EXPECT_NEAR(diagnose(mesh).signed_volume, volume, 0.01 * volume);
}

TEST(ClosedSurface, AThinPlateKeepsItsThickness) {
  const Vector3d half(0.7, 0.5, 0.021);  // 1.3 cells thick
  const auto distance = [&](const Vector3d& at) { return box(at, half); };
  const Mesh mesh = closed_surface(field_of(centred_lattice(64, 1), 4, distance)).mesh;
  expect_closed(mesh);
  EXPECT_EQ(euler_characteristic(mesh), 2);
  double highest = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices) highest = std::max(highest, double(std::abs(vertex.z())));
  EXPECT_NEAR(highest, half.z(), 1e-6);
}

TEST(ClosedSurface, FillsCavities) {
  const auto distance = [](const Vector3d& at) {
    const double shell = std::abs(at.norm() - 0.6) - 0.2, island = ball(at, {0.05, 0, 0}, 0.15);
    return std::min(shell, island);
  };
  const ClosedSurface surface = closed_surface(field_of(centred_lattice(72, 1), 3, distance));
  expect_closed(surface.mesh);
  EXPECT_EQ(euler_characteristic(surface.mesh), 2);
  EXPECT_EQ(surface.counts.cavities, 1u);
  EXPECT_EQ(surface.counts.pieces, 1u);
  const double volume = 4.0 / 3 * M_PI * std::pow(0.8, 3);
  EXPECT_NEAR(diagnose(surface.mesh).signed_volume, volume, 0.005 * volume);
}

TEST(ClosedSurface, OfTwoPiecesTheLargerStays) {
  const auto distance = [](const Vector3d& at) {
    return std::min(ball(at, {-0.4, 0, 0}, 0.2), ball(at, {0.35, 0, 0}, 0.4));
  };
  const ClosedSurface surface = closed_surface(field_of(centred_lattice(90, 1), 3, distance));
  expect_closed(surface.mesh);
  EXPECT_EQ(surface.counts.pieces, 2u);
  EXPECT_NEAR(surface.counts.left_out, 8.0 / (8 + 64), 0.01);
  for (const Eigen::Vector3f& vertex : surface.mesh.vertices) EXPECT_GT(vertex.x(), -0.1f);
}

TEST(ClosedSurface, WhatLeavesTheLatticeIsClosedAtItsBorder) {
  const auto distance = [](const Vector3d& at) { return ball(at, {0, 0, -1}, 0.7); };
  const ClosedSurface surface = closed_surface(field_of(centred_lattice(57, 1), 3, distance));
  expect_closed(surface.mesh);
  EXPECT_EQ(euler_characteristic(surface.mesh), 2);
  EXPECT_NEAR(surface.forced_outside, M_PI * std::pow(0.7 * 28, 2), 40);
  for (const Eigen::Vector3f& vertex : surface.mesh.vertices) EXPECT_GT(vertex.z(), -1);
}

TEST(ClosedSurface, FarFromZeroItKeepsItsShape) {
  const Vector3d centre(4.5e5, 5.4e6, 120);
  Lattice lattice = centred_lattice(40, 1);
  lattice.origin += centre;
  const auto distance = [&](const Vector3d& at) { return ball(at, centre, 0.8); };
  const Mesh mesh = closed_surface(field_of(lattice, 3, distance)).mesh;
  expect_closed(mesh);
  EXPECT_LT(farthest(mesh, distance), interpolation_error(lattice.cell, 0.8));
}

TEST(ClosedSurface, WithoutAnInsideThereIsNone) {
  for (const int points : {0, 1, 2, 3, 9}) {
    const Lattice lattice{.cell = 1, .points = {points, points, points}};
    EXPECT_TRUE(closed_surface(BlockField(lattice)).mesh.triangles.empty());
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(closed_surface(field_of(lattice, 1, [&](const Vector3d&) { return nan; })).mesh.triangles.empty());
    const ClosedSurface full = closed_surface(field_of(lattice, 1, [](const Vector3d&) { return -9.0; }));
    EXPECT_EQ(full.mesh.triangles.empty(), points < 3);
    EXPECT_EQ(full.forced_outside, points * points * points - std::pow(std::max(points - 2, 0), 3));
    if (points >= 3) expect_closed(full.mesh);
  }
}

/// The signs of a field as the definition has them, point by point, and its pieces by a plain search.
class PlainSigns {
 public:
  explicit PlainSigns(const BlockField& field) : n_(field.lattice().points), inside_(n_.prod()) {
    for (int i = 0; i < n_.prod(); ++i) {
      const Eigen::Array3i at = place(i);
      inside_[i] = field.at(at) < 0 && (at > 0).all() && (at < n_ - 1).all();
    }
    fill_cavities();
    keep_largest();
  }
  std::size_t cavities = 0, pieces = 0, all = 0, kept = 0;

  std::size_t crossed_edges() const {
    std::size_t count = 0;
    for (int i = 0; i < n_.prod(); ++i)
      for (const int j : neighbours(i)) count += i < j && inside_[i] != inside_[j];
    return count;
  }

 private:
  Eigen::Array3i place(int i) const { return {i % n_.x(), i / n_.x() % n_.y(), i / (n_.x() * n_.y())}; }
  std::vector<int> neighbours(int i) const {
    std::vector<int> found;
    for (int corner = 1; corner < 8; ++corner)
      for (const int sign : {-1, 1}) {
        const Eigen::Array3i at = place(i) + sign * Eigen::Array3i(corner & 1, corner >> 1 & 1, corner >> 2);
        if ((at >= 0).all() && (at < n_).all()) found.push_back(at.x() + n_.x() * (at.y() + n_.y() * at.z()));
      }
    return found;
  }
  std::vector<int> piece(int from, std::vector<bool>& seen) const {
    std::vector<int> found{from};
    seen[from] = true;
    for (std::size_t k = 0; k < found.size(); ++k)
      for (const int j : neighbours(found[k]))
        if (!seen[j] && inside_[j] == inside_[from]) seen[j] = true, found.push_back(j);
    return found;
  }
  void fill_cavities() {
    std::vector<bool> seen(inside_.size(), false);
    piece(0, seen);
    std::vector<int> filled;
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      if (inside_[i] || seen[i]) continue;
      ++cavities;
      const std::vector<int> cavity = piece(static_cast<int>(i), seen);
      filled.insert(filled.end(), cavity.begin(), cavity.end());
    }
    for (const int i : filled) inside_[i] = true;
  }
  void keep_largest() {
    std::vector<bool> seen(inside_.size(), false);
    std::vector<int> largest;
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      if (!inside_[i] || seen[i]) continue;
      const std::vector<int> found = piece(static_cast<int>(i), seen);
      ++pieces;
      all += found.size();
      if (found.size() > largest.size()) largest = found;
    }
    std::fill(inside_.begin(), inside_.end(), false);
    for (const int j : largest) inside_[j] = true;
    kept = largest.size();
  }

  Eigen::Array3i n_;
  std::vector<bool> inside_;
};

/// Noise whose blocks are stored or not by chance, of values that no distance has.
BlockField noise(unsigned seed) {
  std::mt19937 random(seed);
  const auto whole = [&](int most) { return static_cast<int>(random() % (most + 1)); };
  BlockField field({.origin = {1, -2, 3}, .cell = 0.1, .points = {3 + whole(30), 3 + whole(30), 3 + whole(30)}});
  const double inside = 0.1 + 0.8 * whole(100) / 100, stored = whole(3) / 3.0;
  std::uniform_real_distribution<double> chance(0, 1);
  const std::array<float, 6> odd{0.0f,  -0.0f,   std::numeric_limits<float>::quiet_NaN(),
                                 1e30f, -1e-30f, -std::numeric_limits<float>::infinity()};
  for (int z = 0; z < field.blocks().z(); ++z)
    for (int y = 0; y < field.blocks().y(); ++y)
      for (int x = 0; x < field.blocks().x(); ++x) {
        field.fill({x, y, z}, chance(random) < inside);
        if (chance(random) > stored) continue;
        float* values = field.store({x, y, z});
        for (int i = 0; i < BlockField::kBlockPoints; ++i)
          values[i] = chance(random) < 0.05 ? odd[random() % odd.size()]
                                            : static_cast<float>((chance(random) < inside ? -1 : 1) * chance(random));
      }
  return field;
}

TEST(ClosedSurface, OfNoiseIsClosedAndOnePiece) {
  std::size_t filled = 0, torn = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const BlockField field = noise(seed);
    const ClosedSurface surface = closed_surface(field);
    const PlainSigns plain(field);
    EXPECT_EQ(surface.counts.cavities, plain.cavities);
    EXPECT_EQ(surface.counts.pieces, plain.pieces);
    EXPECT_NEAR(surface.counts.left_out, plain.all ? 1 - double(plain.kept) / plain.all : 0, 1e-12);
    EXPECT_EQ(surface.mesh.vertices.size(), plain.crossed_edges());
    if (plain.kept > 0) expect_closed(surface.mesh);
    filled += plain.cavities > 0;
    torn += plain.pieces > 1;
  }
  EXPECT_GT(filled, 10u);
  EXPECT_GT(torn, 10u);
}

}  // namespace
}  // namespace sheen
