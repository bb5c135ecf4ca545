// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheen {

/// The data set (`transforms.json`) that COLMAP made of a folder of photographs.
struct PosedPhotographs {
  std::filesystem::path folder;       ///< beside theirs: `NAME.posed`
  std::size_t photographs = 0;        ///< that there are
  std::size_t groups = 1;             ///< that hang together, of which the largest is used; 0 where it is not known
  std::vector<std::string> left_out;  ///< the names of those without a pose
  bool found_before = false;          ///< by an earlier run, of the same photographs
  std::optional<double> size_m;  ///< the object's greatest length, where somebody measured it; else no length is true
};

/// Whether a folder has photographs (JPEG, PNG, WebP) in it and nothing that says where they were taken from.
bool is_photographs_alone(const std::filesystem::path& folder);

/// Finds poses of the photographs in a folder by COLMAP, unless an earlier run has found those of the same photographs.
/// Photographs of one size are taken for one camera's. The folder itself is not written to: beside it are `NAME.posed`
/// and what COLMAP said, `NAME.posed.log`. Throws as `run_colmap` does, and FileError where `NAME.posed` is something
/// else or cannot be written.
PosedPhotographs pose_photographs(const std::filesystem::path& folder);

/// Brings such a data set to the unit in which the object is as long as was measured: all lengths are `factor` times as
/// many. Throws FileError.
void set_size(const std::filesystem::path& posed, double factor, double size_m);

}  // namespace sheen
