// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/base/progress.h"
#include "common/image/exr.h"
#include "reconstructor/models/model_kind.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

struct SaveOptions {
  ExrPrecision surface = ExrPrecision::kFloat;  ///< of the surface maps; with half a reopened model is not the same
  StepsDone progress;
};

/// Writes a surface light field as a folder that is created where needed:
///   mesh.ply    the mesh
///   model.json  version, conventions, a triangle's lattice resolution, list of patches and of
///               their vertices with their kernels, metadata
///   maps.exr    surface.rank00 ...  atlas of all patches' basis rows, RGB
///               measured            the same atlas: fraction of the patch's images that showed the sample: 0 unseen,
///                                   below 1/2 imputed, else measured (older models have 1 wherever any did)
///               views               directions and weights, one pixel per view of a vertex
///               vertices            frame, mean and drift coefficients, one pixel per vertex of a patch
/// They are written into the folder ".unfinished" in it and moved when all are whole: until then an older model stays.
/// model.json comes last and is tied to the other two, so a save that was cut short is noticed. Throws FileError.
void save_model(const SurfaceLightFieldSnapshot& model, const std::filesystem::path& folder,
                const ModelMetadata& metadata = {}, const SaveOptions& options = {});

/// Opens such a folder: the model renders as the one that was saved, bit for bit. Throws FileError that names file and
/// part where one is missing or broken, and both versions where the folder was written by another version of Sheen.
/// `show` gets the mesh, which is there long before its maps are.
std::shared_ptr<const SurfaceLightFieldSnapshot> load_model(const std::filesystem::path& folder,
                                                            const ShowModel& show = {});

ModelMetadata load_model_metadata(const std::filesystem::path& folder);

}  // namespace sheen
