// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "reconstructor/numerics/online_svd.h"
#include "reconstructor/studies/batch_light_field.h"

namespace sheen {

/// Patches to try factorizations on, spread over the mesh: at most `most` of those that at least `least_views` images
/// show whole, with these images' columns only, so that nothing is missing.
std::vector<PatchMatrix> whole_patches(const BatchLightField& light_field, int least_views, std::size_t most);

/// The same of patches where at least `least_views` images show something, but not all show the whole patch.
std::vector<PatchMatrix> patches_with_holes(const BatchLightField& light_field, int least_views, std::size_t most);

/// What is left of all patches together, ||C - B Y|| / ||C||, by the best approximation there is (batch PCA).
double batch_error(std::span<const PatchMatrix> patches, int rank);

/// The same of the displayed terms of online factorizations that see each patch's columns in an order of their own:
/// `orders[i]` lists the columns of patch i.
double online_error(std::span<const PatchMatrix> patches, std::span<const std::vector<int>> orders,
                    const OnlineSvdOptions& options);

/// How badly the best basis there is, of `rank` terms, explains what images show of patches with holes: nats for each
/// known value (`surprise`, `batch_pca_missing`); images are weighted as in a light field.
double batch_surprise(std::span<const PatchMatrix> patches, int rank);
/// The same of the displayed terms of online factorizations.
double online_surprise(std::span<const PatchMatrix> patches, std::span<const std::vector<int>> orders,
                       const OnlineSvdOptions& options);

/// Columns of each patch in the order in which `images` (a place for each image) runs.
std::vector<std::vector<int>> orders_by_image(std::span<const PatchMatrix> patches,
                                              std::span<const std::uint32_t> images);
/// Columns of each patch by rising, or falling, norm.
std::vector<std::vector<int>> orders_by_norm(std::span<const PatchMatrix> patches, bool rising);

}  // namespace sheen
