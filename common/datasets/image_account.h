// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace sheen {

/// What became of the image files of a data set.
struct ImageAccount {
  struct LeftOut {
    std::string name, why;
    std::filesystem::path file = {};  ///< where there is one
  };
  std::size_t images = 0;           ///< that are used
  std::size_t of = 0;               ///< those, those left out, and those that lie beside them and are not named
  std::size_t masks = 0;            ///< of the images used
  std::size_t unused_alphas = 0;    ///< of images that have a mask file, too
  bool masks_are_alpha = false;     ///< else files
  std::vector<LeftOut> left_out;    ///< named, but missing or damaged
  std::vector<std::string> unused;  ///< image files below the root that are neither image nor mask, as seen from it
  std::map<std::string, std::vector<std::string>>
      other_colours;              ///< images that say they are not sRGB, by what they say
  std::vector<std::string> grey;  ///< images without colours among images with colours
};

/// Looks for image files below `root` that are not among `used` (images and masks), some levels deep, and counts those
/// that lie beside `images` and have a name of their own, so that they may be more of the same.
void look_for_unused(ImageAccount& account, const std::filesystem::path& root,
                     std::span<const std::filesystem::path> images, std::span<const std::filesystem::path> masks);

/// Throws FileError, naming the first that is left out, where fewer than half of those named are used.
void refuse_few(const std::filesystem::path& description, const ImageAccount& account);

/// Lines for a person, `root` before the first: "N of M images, K masks", then what is left out, unused or grey, by
/// name, at most ten of each.
std::string in_words(const ImageAccount& account, const std::filesystem::path& root);

}  // namespace sheen
