// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/patch_sample.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "reconstructor/models/surface_light_field/patch_model.h"

namespace sheen {
namespace {

struct Energies {
  double lost = 0, all = 0;
};

/// Adds up a patch at a time, in the patches' order.
Energies sum_over(std::size_t patches, const std::function<Energies(std::size_t)>& of_patch) {
  std::vector<Energies> energies(patches);
  tbb::parallel_for(std::size_t{0}, patches, [&](std::size_t i) { energies[i] = of_patch(i); });
  Energies sum;
  for (const Energies& e : energies) {
    sum.lost += e.lost;
    sum.all += e.all;
  }
  return sum;
}

double relative_error(std::size_t patches, const std::function<Energies(std::size_t)>& of_patch) {
  const Energies sum = sum_over(patches, of_patch);
  return sum.all > 0 ? std::sqrt(sum.lost / sum.all) : 0;
}

/// Nats for each known value of all patches, of a basis for each patch.
double mean_surprise(std::span<const PatchMatrix> patches,
                     const std::function<Eigen::MatrixXd(std::size_t)>& basis_of_patch) {
  const Energies sum = sum_over(patches.size(), [&](std::size_t i) {
    const PatchMatrix& patch = patches[i];
    const double values = static_cast<double>((patch.known != 0).count());
    return Energies{values * surprise(patch.columns, patch.known, basis_of_patch(i), patch.weights()), values};
  });
  return sum.all > 0 ? sum.lost / sum.all : 0;
}

std::vector<PatchMatrix> spread(std::vector<PatchMatrix> patches, std::size_t most) {
  if (patches.size() <= most) return patches;
  std::vector<PatchMatrix> chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(std::move(patches[i * patches.size() / most]));
  return chosen;
}

std::vector<std::vector<int>> orders_by(std::span<const PatchMatrix> patches,
                                        const std::function<double(const PatchMatrix&, int)>& key) {
  std::vector<std::vector<int>> orders;
  for (const PatchMatrix& patch : patches) {
    std::vector<int>& order = orders.emplace_back(patch.views());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(patch, a) < key(patch, b); });
  }
  return orders;
}

}  // namespace

std::vector<PatchMatrix> whole_patches(const BatchLightField& light_field, int least_views, std::size_t most) {
  std::vector<PatchMatrix> patches;
  for (std::size_t v = 0; v < light_field.patches(); ++v) {
    const PatchMatrix all = light_field.patch(v);
    std::vector<int> whole;
    for (int j = 0; j < all.views(); ++j)
      if ((all.known.col(j) != 0).all()) whole.push_back(j);
    if (static_cast<int>(whole.size()) < least_views) continue;
    PatchMatrix patch{.columns = all.columns(Eigen::all, whole),
                      .known = all.known(Eigen::all, whole),
                      .eyes = all.eyes(Eigen::all, whole),
                      .reliability = all.reliability(Eigen::all, whole)};
    for (const int j : whole) patch.images.push_back(all.images[static_cast<std::size_t>(j)]);
    patches.push_back(std::move(patch));
  }
  return spread(std::move(patches), most);
}

std::vector<PatchMatrix> patches_with_holes(const BatchLightField& light_field, int least_views, std::size_t most) {
  std::vector<PatchMatrix> patches;
  for (std::size_t v = 0; v < light_field.patches(); ++v) {
    PatchMatrix patch = light_field.patch(v);
    if (patch.views() >= least_views && !(patch.known != 0).all()) patches.push_back(std::move(patch));
  }
  return spread(std::move(patches), most);
}

double batch_error(std::span<const PatchMatrix> patches, int rank) {
  return relative_error(patches.size(), [&](std::size_t i) {
    const BatchPca pca = batch_pca(patches[i].columns, rank);
    const double all = patches[i].columns.cast<double>().squaredNorm();
    return Energies{pca.relative_error * pca.relative_error * all, all};
  });
}

double online_error(std::span<const PatchMatrix> patches, std::span<const std::vector<int>> orders,
                    const OnlineSvdOptions& options) {
  return relative_error(patches.size(), [&](std::size_t i) {
    const Eigen::MatrixXf columns = patches[i].columns(Eigen::all, orders[i]);
    OnlineSvd factor(static_cast<int>(columns.rows()), options);
    for (Eigen::Index j = 0; j < columns.cols(); ++j) factor.add(columns.col(j));
    const OnlineSvd all = factor.settled();
    const Eigen::MatrixXd left = (columns - all.displayed_basis() * all.displayed_coefficients()).cast<double>();
    return Energies{left.squaredNorm(), columns.cast<double>().squaredNorm()};
  });
}

double batch_surprise(std::span<const PatchMatrix> patches, int rank) {
  const auto basis = [&](std::size_t i) {
    return batch_pca_missing(patches[i].columns, patches[i].known, rank, patches[i].weights()).basis;
  };
  return mean_surprise(patches, basis);
}

double online_surprise(std::span<const PatchMatrix> patches, std::span<const std::vector<int>> orders,
                       const OnlineSvdOptions& options) {
  return mean_surprise(patches, [&](std::size_t i) -> Eigen::MatrixXd {
    return online_factor(patches[i], options, orders[i]).displayed_basis().cast<double>();
  });
}

std::vector<std::vector<int>> orders_by_image(std::span<const PatchMatrix> patches,
                                              std::span<const std::uint32_t> images) {
  std::vector<double> place(images.size());
  for (std::size_t k = 0; k < images.size(); ++k) place[images[k]] = static_cast<double>(k);
  return orders_by(patches,
                   [&](const PatchMatrix& patch, int j) { return place[patch.images[static_cast<std::size_t>(j)]]; });
}

std::vector<std::vector<int>> orders_by_norm(std::span<const PatchMatrix> patches, bool rising) {
  return orders_by(patches, [rising](const PatchMatrix& patch, int j) {
    const double norm = patch.columns.col(j).norm();
    return rising ? norm : -norm;
  });
}

}  // namespace sheen
