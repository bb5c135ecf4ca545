// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/ring_sample.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "reconstructor/models/surface_light_field/ring_model.h"

namespace sheen {
namespace {

struct Energies {
  double lost = 0, all = 0;
};

/// Adds up a ring at a time, in the rings' order.
Energies sum_over(std::size_t rings, const std::function<Energies(std::size_t)>& of_ring) {
  std::vector<Energies> energies(rings);
  tbb::parallel_for(std::size_t{0}, rings, [&](std::size_t i) { energies[i] = of_ring(i); });
  Energies sum;
  for (const Energies& e : energies) {
    sum.lost += e.lost;
    sum.all += e.all;
  }
  return sum;
}

double relative_error(std::size_t rings, const std::function<Energies(std::size_t)>& of_ring) {
  const Energies sum = sum_over(rings, of_ring);
  return sum.all > 0 ? std::sqrt(sum.lost / sum.all) : 0;
}

/// Nats for each known value of all rings, of a basis for each ring.
double mean_surprise(std::span<const RingMatrix> rings,
                     const std::function<Eigen::MatrixXd(std::size_t)>& basis_of_ring) {
  const Energies sum = sum_over(rings.size(), [&](std::size_t i) {
    const RingMatrix& ring = rings[i];
    const double values = static_cast<double>((ring.known != 0).count());
    return Energies{values * surprise(ring.columns, ring.known, basis_of_ring(i), ring.weights()), values};
  });
  return sum.all > 0 ? sum.lost / sum.all : 0;
}

std::vector<RingMatrix> spread(std::vector<RingMatrix> rings, std::size_t most) {
  if (rings.size() <= most) return rings;
  std::vector<RingMatrix> chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(std::move(rings[i * rings.size() / most]));
  return chosen;
}

std::vector<std::vector<int>> orders_by(std::span<const RingMatrix> rings,
                                        const std::function<double(const RingMatrix&, int)>& key) {
  std::vector<std::vector<int>> orders;
  for (const RingMatrix& ring : rings) {
    std::vector<int>& order = orders.emplace_back(ring.views());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(ring, a) < key(ring, b); });
  }
  return orders;
}

}  // namespace

std::vector<RingMatrix> whole_rings(const BatchLightField& light_field, int least_views, std::size_t most) {
  std::vector<RingMatrix> rings;
  for (std::size_t v = 0; v < light_field.rings(); ++v) {
    const RingMatrix all = light_field.ring(v);
    std::vector<int> whole;
    for (int j = 0; j < all.views(); ++j)
      if ((all.known.col(j) != 0).all()) whole.push_back(j);
    if (static_cast<int>(whole.size()) < least_views) continue;
    RingMatrix ring{.columns = all.columns(Eigen::all, whole),
                    .known = all.known(Eigen::all, whole),
                    .directions = all.directions(Eigen::all, whole),
                    .cosines = all.cosines(whole)};
    for (const int j : whole) ring.images.push_back(all.images[static_cast<std::size_t>(j)]);
    rings.push_back(std::move(ring));
  }
  return spread(std::move(rings), most);
}

std::vector<RingMatrix> rings_with_holes(const BatchLightField& light_field, int least_views, std::size_t most) {
  std::vector<RingMatrix> rings;
  for (std::size_t v = 0; v < light_field.rings(); ++v) {
    RingMatrix ring = light_field.ring(v);
    if (ring.views() >= least_views && !(ring.known != 0).all()) rings.push_back(std::move(ring));
  }
  return spread(std::move(rings), most);
}

double batch_error(std::span<const RingMatrix> rings, int rank) {
  return relative_error(rings.size(), [&](std::size_t i) {
    const BatchPca pca = batch_pca(rings[i].columns, rank);
    const double all = rings[i].columns.cast<double>().squaredNorm();
    return Energies{pca.relative_error * pca.relative_error * all, all};
  });
}

double online_error(std::span<const RingMatrix> rings, std::span<const std::vector<int>> orders,
                    const RingFactorOptions& options) {
  return relative_error(rings.size(), [&](std::size_t i) {
    const Eigen::MatrixXf columns = rings[i].columns(Eigen::all, orders[i]);
    RingFactor factor(static_cast<int>(columns.rows()), options);
    for (Eigen::Index j = 0; j < columns.cols(); ++j) factor.add(columns.col(j));
    const RingFactor all = factor.settled();
    const Eigen::MatrixXd left = (columns - all.displayed_basis() * all.displayed_coefficients()).cast<double>();
    return Energies{left.squaredNorm(), columns.cast<double>().squaredNorm()};
  });
}

double batch_surprise(std::span<const RingMatrix> rings, int rank) {
  const auto basis = [&](std::size_t i) {
    return batch_pca_missing(rings[i].columns, rings[i].known, rank, rings[i].weights()).basis;
  };
  return mean_surprise(rings, basis);
}

double online_surprise(std::span<const RingMatrix> rings, std::span<const std::vector<int>> orders,
                       const RingFactorOptions& options) {
  return mean_surprise(rings, [&](std::size_t i) -> Eigen::MatrixXd {
    return online_factor(rings[i], options, orders[i]).displayed_basis().cast<double>();
  });
}

std::vector<std::vector<int>> orders_by_image(std::span<const RingMatrix> rings,
                                              std::span<const std::uint32_t> images) {
  std::vector<double> place(images.size());
  for (std::size_t k = 0; k < images.size(); ++k) place[images[k]] = static_cast<double>(k);
  return orders_by(rings,
                   [&](const RingMatrix& ring, int j) { return place[ring.images[static_cast<std::size_t>(j)]]; });
}

std::vector<std::vector<int>> orders_by_norm(std::span<const RingMatrix> rings, bool rising) {
  return orders_by(rings, [rising](const RingMatrix& ring, int j) {
    const double norm = ring.columns.col(j).norm();
    return rising ? norm : -norm;
  });
}

}  // namespace sheen
