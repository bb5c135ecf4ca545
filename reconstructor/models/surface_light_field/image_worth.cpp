// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/image_worth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr std::size_t kRingsLookedAt = 200;
constexpr float kMinFacing = 0.2f;        // cosine: as the visibility test asks
constexpr float kUnseen = 1.6f;           // rad: the distance to the nearest image where there is none
constexpr double kPriorVariation = 1e-3;  // mean square of encoded values, before any image
constexpr double kPriorViews = 4;         // views that the rings' common variation with the view counts for

/// How much a ring varies with the view: sum over its views of the mean square over its rows, encoded values.
struct Variation {
  double sum = 0, views = 0;
};

Variation variation_of(const RingSnapshot& ring) {
  Variation variation{.views = static_cast<double>(ring.directions.cols())};
  const double rows = static_cast<double>(ring.basis.rows());
  for (Eigen::Index j = 0; j < ring.directions.cols(); ++j) {
    const Eigen::VectorXf h = ring.coefficients(ring.directions.col(j));
    const double unexplained = ring.residual * ring.residual * h.squaredNorm();
    variation.sum += ((h - ring.mean).squaredNorm() + unexplained) / rows;
  }
  return variation;
}

/// A place as a ring sees it.
struct Place {
  std::size_t eye;
  Eigen::Vector3f direction;
  float facing;
  float nearest;  ///< angle to the nearest image of the ring, rad
};

std::vector<Place> places_in_sight(const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal,
                                   const RingSnapshot* ring, std::span<const Eigen::Vector3d> eyes) {
  std::vector<Place> places;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    Place place{e, (eyes[e].cast<float>() - vertex).normalized(), 0, kUnseen};
    place.facing = normal.dot(place.direction);
    if (place.facing < kMinFacing) continue;
    if (ring)
      for (Eigen::Index j = 0; j < ring->directions.cols(); ++j)
        place.nearest = std::min(place.nearest, angle_between(place.direction, ring->directions.col(j)));
    places.push_back(place);
  }
  return places;
}

struct Worth {
  std::vector<double> distance, approach;  ///< an eye
};

}  // namespace

std::vector<double> image_worth(const SurfaceLightFieldSnapshot& snapshot, std::span<const Eigen::Vector3d> eyes) {
  const Mesh& mesh = snapshot.mesh();
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kRingsLookedAt);
  std::vector<std::size_t> looked_at;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) looked_at.push_back(v);
  const auto ring_of = [&](std::size_t i) {
    const RingSnapshot* ring = snapshot.ring_data()[looked_at[i]].get();
    return ring && ring->rank() > 0 ? ring : nullptr;
  };

  std::vector<Variation> variations(looked_at.size());
  tbb::parallel_for(std::size_t{0}, looked_at.size(), [&](std::size_t i) {
    if (const RingSnapshot* ring = ring_of(i)) variations[i] = variation_of(*ring);
  });
  Variation common{kPriorVariation, 1};
  for (const Variation& v : variations) {
    common.sum += v.sum;
    common.views += v.views;
  }

  std::vector<Worth> by_ring(looked_at.size());
  tbb::parallel_for(std::size_t{0}, looked_at.size(), [&](std::size_t i) {
    const std::size_t v = looked_at[i];
    const std::vector<Place> places = places_in_sight(mesh.vertices[v], normals[v], ring_of(i), eyes);
    const double variation =
        std::sqrt((variations[i].sum + kPriorViews * common.sum / common.views) / (variations[i].views + kPriorViews));
    Worth& worth = by_ring[i];
    worth.distance.assign(eyes.size(), 0);
    worth.approach.assign(eyes.size(), 0);
    for (const Place& image : places) {
      worth.distance[image.eye] = image.facing * variation * image.nearest;
      for (const Place& seen : places) {
        const float nearer = seen.nearest - angle_between(seen.direction, image.direction);
        if (nearer > 0) worth.approach[image.eye] += seen.facing * variation * nearer;
      }
    }
  });
  std::vector<double> worth(eyes.size(), 0);
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    double distance = 0, approach = 0;
    for (const Worth& ring : by_ring) {
      distance += ring.distance[e];
      approach += ring.approach[e];
    }
    worth[e] = std::sqrt(distance * approach);
  }
  return worth;
}

}  // namespace sheen
