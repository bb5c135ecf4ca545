// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

/// Photographs that one camera took with one lens: their names as seen from their folder.
using OneCamera = std::vector<std::string>;

/// Finds where photographs in `images` were taken from, by COLMAP's programs: features, matches, mapping. Its models
/// are in `work/sparse`, a folder each, in frames and units of their own; there is one at least. What COLMAP says is
/// appended to `log`. Bars show how far it is; four threads at most work, on pictures of 2000 pixels at most. Throws
/// Error where COLMAP is not installed (with what to do), where a step fails (with the last lines of its log), where
/// the photographs have too little in common, and where a stop signal ends it (`stop_requested`).
void run_colmap(const std::filesystem::path& images, const std::vector<OneCamera>& cameras,
                const std::filesystem::path& work, const std::filesystem::path& log);

}  // namespace sheen
