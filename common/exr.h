// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/image.h"

namespace sheen {

enum class ExrPrecision { kHalf, kFloat };

/// One named part of an EXR file. `channels` names the image's channels in order: {"R","G","B"}, {"Z"}, ...
struct ExrPart {
  std::string name;
  std::vector<std::string> channels;
  ImageF image;
  ExrPrecision precision = ExrPrecision::kFloat;
};

/// String attributes of the file ("cameraModel", "sheen.metrics", ...).
using ExrAttributes = std::map<std::string, std::string>;

struct ExrFile {
  std::vector<ExrPart> parts;
  ExrAttributes attributes;
  /// Null when there is no such part.
  const ExrPart* find(const std::string& name) const;
};

/// Multi-part scan-line file, ZIP compressed; part 0 is what simple readers show. Throws FileError.
void write_exr(const std::filesystem::path& path, const ExrFile& file);

/// A single RGB or grey image.
void write_exr(const std::filesystem::path& path, const ImageF& image);

/// Throws FileError for anything that is not a readable EXR of flat scan-line or tiled parts.
ExrFile read_exr(const std::filesystem::path& path);

}  // namespace sheen
