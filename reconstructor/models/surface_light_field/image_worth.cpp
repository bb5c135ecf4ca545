// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/image_worth.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr std::size_t kVerticesLookedAt = 200;
constexpr float kMinFacing = 0.2f;  // cosine: more than the visibility test asks, which oblique images just pass
constexpr double kLevel = 0.5;      // variance of a vertex's level, in units of how much it varies with the view
constexpr float kReach = 0.8f;      // rad: over which two images of a vertex tell of each other
constexpr double kNoise = 0.05;
constexpr double kUnseen = 0.02;  // mean square of encoded values, by which a guess of what no image shows is wrong
constexpr double kGuessedShape = 2.5e-3;  // the same, by which views differ of what is not where it is taken to be
constexpr double kPriorVariation = 1e-3;  // mean square of encoded values, before any image
constexpr double kPriorViews = 4;         // views that the vertices' common variation with the view counts for

/// How much a vertex varies with the view: sum over its views of the mean square over its rows, encoded values.
struct Variation {
  double sum = 0, views = 0;
};

/// Covariance of what a vertex shows from two directions, in units of how much it varies with the view.
double covariance(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return kLevel + std::exp(-angle_between(a, b) / kReach);
}

/// A picture shows the vertex the less exactly, the more obliquely.
double noise(float facing) {
  return kNoise / std::max(facing, 0.5f * kMinFacing);
}

/// Places in sight of a vertex, and how uncertain it is from there.
struct Sight {
  std::vector<std::size_t> eyes;
  std::vector<float> facing;
  Eigen::VectorXd variance;  ///< in units of how much the vertex varies with the view
};

Sight sight_of(const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal, const SeenVertex* from,
               std::span<const Eigen::Vector3d> eyes) {
  Sight sight;
  std::vector<Eigen::Vector3f> directions;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    const Eigen::Vector3f direction = (eyes[e].cast<float>() - vertex).normalized();
    const float facing = normal.dot(direction);
    if (facing < kMinFacing) continue;
    sight.eyes.push_back(e);
    sight.facing.push_back(facing);
    directions.push_back(direction);
  }
  const auto n = static_cast<Eigen::Index>(directions.size());
  const Eigen::Index views = from ? from->views->directions.cols() : 0;
  sight.variance = Eigen::VectorXd::Constant(n, kLevel + 1);
  if (views == 0 || n == 0) return sight;
  const Eigen::Matrix3Xf& seen_from = from->views->directions;
  Eigen::MatrixXd among(views, views), across(views, n);
  for (Eigen::Index a = 0; a < views; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) among(a, b) = among(b, a) = covariance(seen_from.col(a), seen_from.col(b));
    among(a, a) += noise(normal.dot(seen_from.col(a)));
    for (Eigen::Index i = 0; i < n; ++i)
      across(a, i) = covariance(seen_from.col(a), directions[static_cast<std::size_t>(i)]);
  }
  Eigen::LLT<Eigen::MatrixXd>(among).matrixL().solveInPlace(across);
  sight.variance -= across.colwise().squaredNorm().transpose();
  return sight;
}

}  // namespace

std::vector<double> image_worth(const LightFieldSnapshot& snapshot, std::span<const Eigen::Vector3d> eyes) {
  const Mesh& mesh = snapshot.mesh();
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kVerticesLookedAt);
  std::vector<std::size_t> looked_at;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) looked_at.push_back(v);
  const auto seen_at = [&](std::size_t i) { return snapshot.seen_vertex(looked_at[i]); };

  std::vector<Variation> variations(looked_at.size());
  tbb::parallel_for(std::size_t{0}, looked_at.size(), [&](std::size_t i) {
    if (const SeenVertex* from = seen_at(i)) {
      const auto views = static_cast<double>(from->views->directions.cols());
      variations[i] = {snapshot.vertex_variation(looked_at[i]) * views, views};
    }
  });
  Variation common{kPriorVariation, 1};
  for (const Variation& v : variations) {
    common.sum += v.sum;
    common.views += v.views;
  }

  std::vector<std::vector<double>> by_ring(looked_at.size());
  tbb::parallel_for(std::size_t{0}, looked_at.size(), [&](std::size_t i) {
    const std::size_t v = looked_at[i];
    const double variation =
        (variations[i].sum + kPriorViews * common.sum / common.views) / (variations[i].views + kPriorViews) +
        (mesh.guessed_at(v) ? kGuessedShape : 0);
    const SeenVertex* const from = seen_at(i);
    const Sight sight = sight_of(mesh.vertices[v], normals[v], from, eyes);
    by_ring[i].assign(eyes.size(), 0);
    for (std::size_t k = 0; k < sight.eyes.size(); ++k)
      by_ring[i][sight.eyes[k]] =
          sight.facing[k] * (variation * sight.variance[static_cast<Eigen::Index>(k)] + (from ? 0 : kUnseen));
  });
  std::vector<double> worth(eyes.size(), 0);
  for (const std::vector<double>& from : by_ring)
    for (std::size_t e = 0; e < eyes.size(); ++e) worth[e] += from[e];
  return worth;
}

}  // namespace sheen
