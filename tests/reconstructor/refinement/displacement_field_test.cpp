// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/displacement_field.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "reconstructor/refinement/selected_inverse.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// The normal equations as their definition has them, dense.
Eigen::MatrixXd dense_equations(const MeshEdges& edges, const Observations& observed, const DisplacementPrior& prior) {
  Eigen::MatrixXd equations = observed.information.asDiagonal();
  equations.diagonal().array() += prior.ridge;
  for (const auto& [a, b] : edges.edges) {
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(equations.rows());
    difference[a] = 1;
    difference[b] = -1;
    equations += prior.stiffness * difference * difference.transpose();
  }
  return equations;
}

TEST(DisplacementField, IsTheSolutionAndTheVarianceOfItsNormalEquations) {
  const MeshEdges edges(sphere_mesh(1, 2));
  const auto n = static_cast<Eigen::Index>(edges.first.size() - 1);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> information(0, 4);
  // Values that agree within their variance: the robust weights stay near one and the field is near the linear one.
  Observations observed(n);
  for (Eigen::Index v = 0; v < n; ++v)
    if (v % 3 != 0) observed.add(v, 0.25, information(random));
  const DisplacementPrior prior{.stiffness = 0.8, .ridge = 1e-9};
  const DisplacementField field = most_probable_field(edges, {&observed, 1}, prior, true);
  const Eigen::MatrixXd inverse = dense_equations(edges, observed, prior).inverse();
  EXPECT_LT((field.value.array() - 0.25).abs().maxCoeff(), 1e-6);
  EXPECT_LT((field.variance - inverse.diagonal()).cwiseAbs().maxCoeff(), 1e-9 * inverse.diagonal().maxCoeff());
}

TEST(DisplacementField, AnObservationThatItsNeighboursContradictCountsLittle) {
  const MeshEdges edges(sphere_mesh(1, 2));
  const auto n = static_cast<Eigen::Index>(edges.first.size() - 1);
  Observations observed(n);
  for (Eigen::Index v = 0; v < n; ++v) observed.add(v, v == 40 ? 100 : 1, 1);
  const DisplacementField field = most_probable_field(edges, {&observed, 1}, {.stiffness = 1, .ridge = 1e-6}, false);
  EXPECT_NEAR(field.value[40], 1, 0.1);
}

TEST(SelectedInverse, IsTheDiagonalOfTheInverse) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  const int n = 60;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (int k = 0; k < 150; ++k) {
    const int i = static_cast<int>(random() % n), j = static_cast<int>(random() % n);
    if (i != j) dense(i, j) = dense(j, i) = value(random);
  }
  dense.diagonal().setConstant(20);
  const SparseMatrix sparse = dense.sparseView();
  const Eigen::SimplicialLDLT<SparseMatrix> factor(sparse);
  EXPECT_LT((diagonal_of_inverse(factor) - dense.inverse().diagonal()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Observations, AreMergedByTheirInformation) {
  Observations observed(1);
  observed.add(0, 1, 3);
  observed.add(0, 5, 1);
  EXPECT_DOUBLE_EQ(observed.value[0], 2);
  EXPECT_DOUBLE_EQ(observed.information[0], 4);
}

TEST(DisplacementField, WhatNothingObservesContinuesTheRest) {
  // On a square grid whose border is observed, a linear function is the harmonic one between its values there.
  constexpr int kSide = 8;
  Mesh mesh = square_mesh(0.1f, 0, kSide);
  const Eigen::Index on_grid = static_cast<Eigen::Index>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{1, 0, 0}, {1, 1, 0}, {2, 0, 0}});  // an island that nothing observes
  const auto first = static_cast<std::uint32_t>(on_grid);
  mesh.triangles.push_back({first, first + 1, first + 2});
  Observations observed(static_cast<Eigen::Index>(mesh.vertices.size()));
  Eigen::VectorXd values = Eigen::VectorXd::Constant(observed.value.size(), 7);  // what is not observed counts nothing
  const auto linear = [&](Eigen::Index v) { return 0.3 + 2 * mesh.vertices[v].x() - mesh.vertices[v].y(); };
  for (Eigen::Index v = 0; v < on_grid; ++v)
    if (mesh.vertices[v].head<2>().cwiseAbs().maxCoeff() > 0.09f) {
      observed.add(v, 0, 1);
      values[v] = linear(v);
    }
  continue_smoothly(MeshEdges(mesh), observed, values);
  for (Eigen::Index v = 0; v < on_grid; ++v) EXPECT_NEAR(values[v], linear(v), 1e-6);
  for (Eigen::Index v = on_grid; v < values.size(); ++v) EXPECT_EQ(values[v], 0);
}

}  // namespace
}  // namespace sheen
