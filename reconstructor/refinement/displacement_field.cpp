// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/displacement_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "reconstructor/refinement/selected_inverse.h"

namespace sheen {
namespace {

constexpr int kReweightings = 4;
constexpr double kContradiction = 3;  // standard deviations from which on an observation counts less and less

SparseMatrix normal_equations(const MeshEdges& edges, const Eigen::VectorXd& information,
                              const DisplacementPrior& prior) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(4 * edges.edges.size() + information.size());
  for (Eigen::Index v = 0; v < information.size(); ++v) entries.emplace_back(v, v, information[v] + prior.ridge);
  for (const auto& [a, b] : edges.edges) {
    entries.emplace_back(a, a, prior.stiffness);
    entries.emplace_back(b, b, prior.stiffness);
    entries.emplace_back(b, a, -prior.stiffness);
  }
  SparseMatrix lower(information.size(), information.size());
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

/// Squared error of a prediction in standard deviations, of the half that did not make it, each counted up to a bound.
double prediction_error(const Eigen::VectorXd& predicted, const Observations& observed) {
  constexpr double kMost = 25;
  double sum = 0;
  for (Eigen::Index v = 0; v < predicted.size(); ++v)
    sum += std::min(kMost, observed.information[v] * std::pow(predicted[v] - observed.value[v], 2));
  return sum;
}

/// Cauchy's weight of an observation where the field has another value.
double trust(const Observations& observed, Eigen::Index vertex, double value) {
  const double squared = observed.information[vertex] * std::pow(value - observed.value[vertex], 2);
  return 1 / (1 + squared / (kContradiction * kContradiction));
}

}  // namespace

void Observations::add(Eigen::Index vertex, double observed, double with_information) {
  const double sum = information[vertex] + with_information;
  if (!(sum > 0)) return;
  value[vertex] += with_information / sum * (observed - value[vertex]);
  information[vertex] = sum;
}

void Observations::add(const Observations& others) {
  for (Eigen::Index v = 0; v < value.size(); ++v) add(v, others.value[v], others.information[v]);
}

DisplacementField most_probable_field(const MeshEdges& edges, std::span<const Observations> sources,
                                      const DisplacementPrior& prior, bool with_variance) {
  DisplacementField field;
  Eigen::SimplicialLDLT<SparseMatrix> solver;
  for (int round = 0; round < kReweightings; ++round) {
    Observations weighted(sources.front().value.size());
    for (const Observations& source : sources)
      for (Eigen::Index v = 0; v < source.value.size(); ++v)
        weighted.add(v, source.value[v], source.information[v] * (round > 0 ? trust(source, v, field.value[v]) : 1));
    const SparseMatrix equations = normal_equations(edges, weighted.information, prior);
    if (round == 0) solver.analyzePattern(equations);
    solver.factorize(equations);
    field.value = solver.solve(weighted.information.cwiseProduct(weighted.value));
  }
  if (with_variance) field.variance = diagonal_of_inverse(solver);
  return field;
}

void continue_smoothly(const MeshEdges& edges, const Observations& observed, Eigen::VectorXd& values) {
  constexpr double kRidge = 1e-9;  // of what has no edge to a vertex with a value
  Eigen::Index free = 0;
  std::vector<Eigen::Index> row(static_cast<std::size_t>(values.size()), -1);
  for (Eigen::Index v = 0; v < values.size(); ++v)
    if (!(observed.information[v] > 0)) row[static_cast<std::size_t>(v)] = free++;
  if (free == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < free; ++i) entries.emplace_back(i, i, kRidge);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(free);
  for (const auto& [a, b] : edges.edges) {
    const Eigen::Index i = row[a], j = row[b];
    if (i >= 0) entries.emplace_back(i, i, 1);
    if (j >= 0) entries.emplace_back(j, j, 1);
    if (i >= 0 && j >= 0) entries.emplace_back(std::max(i, j), std::min(i, j), -1);
    if (i >= 0 && j < 0) right[i] += values[b];
    if (j >= 0 && i < 0) right[j] += values[a];
  }
  SparseMatrix lower(free, free);
  lower.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd continued = Eigen::SimplicialLDLT<SparseMatrix>(lower).solve(right);
  for (Eigen::Index v = 0; v < values.size(); ++v)
    if (row[static_cast<std::size_t>(v)] >= 0) values[v] = continued[row[static_cast<std::size_t>(v)]];
}

DisplacementPrior cross_validated(const MeshEdges& edges, const Observations& first, const Observations& second,
                                  std::span<const DisplacementPrior> priors) {
  DisplacementPrior best;
  double least = std::numeric_limits<double>::infinity();
  for (const DisplacementPrior& prior : priors) {
    const double error = prediction_error(most_probable_field(edges, {&first, 1}, prior, false).value, second) +
                         prediction_error(most_probable_field(edges, {&second, 1}, prior, false).value, first);
    if (error >= least) continue;
    least = error;
    best = prior;
  }
  return best;
}

}  // namespace sheen
