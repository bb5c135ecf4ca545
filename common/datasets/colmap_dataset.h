// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/datasets/dataset.h"
#include "common/datasets/file_finder.h"

namespace sheen {

/// Views of the COLMAP model with most images: in `root`, `root/sparse` or a folder in that; of several with as many
/// the first. Images and masks are looked for in `images`. `kColmapHeldOut` beside its files says what is held out.
/// Empty where there is none. Images that are missing stand in the account. Throws FileError.
struct ColmapViews {
  std::vector<DatasetView> views;
  std::size_t models = 1;   ///< that there are, in frames of their own
  std::string description;  ///< the bytes of its files, hashed
  /// What is not read of several models, or of text beside binary files, and what is held out: a sentence a line.
  std::string remarks;
};
std::optional<ColmapViews> load_colmap(const std::filesystem::path& root, const std::filesystem::path& images,
                                       ImageAccount& account);

/// Whether there is one for it to read.
bool holds_colmap(const std::filesystem::path& root);

/// The mask of an image below `masks` or `mask`: IMAGE.png as COLMAP has it, IMAGE itself, or its stem with another
/// extension, also with `_mask`, `-mask` or `.mask` behind it or `mask_` before it; else its stem with `_mask` beside
/// the image. Empty where there is none.
std::filesystem::path find_colmap_mask(const FileFinder& finder, const std::string& image);

}  // namespace sheen
