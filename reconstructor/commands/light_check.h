// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "common/datasets/light_list.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Throws ConfigError that names model and list where the one cannot be asked for the other's lights.
void require_light_kind(const ModelSnapshot& snapshot, std::span<const LitView> lights,
                        const std::filesystem::path& model, const std::filesystem::path& list);

}  // namespace sheen
