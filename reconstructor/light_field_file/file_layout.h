// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/coding/chunk_file.h"
#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/patch_coding.h"
#include "reconstructor/light_field_file/view_haar.h"

namespace sheen {

// What writing and reading a file have in common (docs/model_format.md).

// Version 2 was read by floating point, by each build a little differently.
inline constexpr ChunkFormat kLightFieldFile{
    .magic = "sheenSLF",
    .version = 3,
    .title = "surface light field",
    .older = "which builds of this program do not read alike; build it again from its session or photographs"};
inline constexpr int kMostLayers = 128;

std::string layer_name(int layer);

/// No patch's step is further from the model's, in quarter octaves: a damaged file asks for anything, and floats end
/// somewhere.
inline constexpr std::int8_t kFurthestPatchStep = 32;
float step_of_patch(float step, std::int8_t quarter_octaves);

/// How each patch is laid out, and how its coefficients are transformed.
struct FileLayout {
  PatchLayout patches;
  std::vector<ViewHaar::Plan> plans;          ///< per patch
  std::vector<std::vector<int>> resolutions;  ///< per patch: of its triangles
  std::vector<float> steps;                   ///< per patch
};

/// `patch_steps`: per patch, in quarter octaves of the model's `step`.
FileLayout file_layout(const CompactModel& model, float step, const std::vector<std::int8_t>& patch_steps,
                       const ForEach& for_each);

}  // namespace sheen
