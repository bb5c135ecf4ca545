// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "reconstructor/numerics/ring_factor.h"
#include "reconstructor/studies/batch_light_field.h"

namespace sheen {

/// Rings to try factorizations on, spread over the mesh: at most `most` of those that at least `least_views` images
/// show whole, with these images' columns only, so that nothing is missing.
std::vector<RingMatrix> whole_rings(const BatchLightField& light_field, int least_views, std::size_t most);

/// The same of rings where at least `least_views` images show something, but not all show the whole ring.
std::vector<RingMatrix> rings_with_holes(const BatchLightField& light_field, int least_views, std::size_t most);

/// What is left of all rings together, ||C - B Y|| / ||C||, by the best approximation there is (batch PCA).
double batch_error(std::span<const RingMatrix> rings, int rank);

/// The same of the displayed terms of online factorizations that see each ring's columns in an order of their own:
/// `orders[i]` lists the columns of ring i.
double online_error(std::span<const RingMatrix> rings, std::span<const std::vector<int>> orders,
                    const RingFactorOptions& options);

/// How badly the best basis there is, of `rank` terms, explains what images show of rings with holes: nats for each
/// known value (`surprise`, `batch_pca_missing`); images are weighted as in a light field.
double batch_surprise(std::span<const RingMatrix> rings, int rank);
/// The same of the displayed terms of online factorizations.
double online_surprise(std::span<const RingMatrix> rings, std::span<const std::vector<int>> orders,
                       const RingFactorOptions& options);

/// Columns of each ring in the order in which `images` (a place for each image) runs.
std::vector<std::vector<int>> orders_by_image(std::span<const RingMatrix> rings, std::span<const std::uint32_t> images);
/// Columns of each ring by rising, or falling, norm.
std::vector<std::vector<int>> orders_by_norm(std::span<const RingMatrix> rings, bool rising);

}  // namespace sheen
