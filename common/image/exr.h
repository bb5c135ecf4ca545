// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/image/image.h"

namespace sheen {

enum class ExrPrecision { kHalf, kFloat };

/// What a part of an EXR file is. `channels` names the image's channels in order: {"R","G","B"}, {"Z"}, ...
struct ExrPartInfo {
  std::string name;
  std::vector<std::string> channels;
  int width = 0, height = 0;
  ExrPrecision precision = ExrPrecision::kFloat;
  int left = 0, top = 0;  ///< of the image in the picture that the file describes; not 0 where it was cropped
  ImageSize picture{};    ///< which all parts have in common; 0 x 0 in what is written: it ends where the image ends
};

/// A part with its pixels.
struct ExrPart {
  std::string name;
  std::vector<std::string> channels;
  ImageF image;
  ExrPrecision precision = ExrPrecision::kFloat;
  int left = 0, top = 0;
  ImageSize picture{};  ///< as in `ExrPartInfo`
};

/// Attributes of the file ("cameraModel", "sheen.metrics", ...) as text; the standard's numbers ("expTime", "isoSpeed",
/// "aperture") are stored as such, and so are "envmap", "latlong" or "cube", and "chromaticities": x and y of red,
/// green, blue and white.
using ExrAttributes = std::map<std::string, std::string>;

struct ExrFile {
  std::vector<ExrPart> parts;
  ExrAttributes attributes;
  /// Null when there is no such part.
  const ExrPart* find(const std::string& name) const;
};

/// Multi-part scan-line file, ZIP compressed; part 0 is what simple readers show. Finite values beyond the range of
/// half are clamped to it. The file is complete or not there at all. Throws FileError.
void write_exr(const std::filesystem::path& path, const ExrFile& file);

/// The same for files too large to have in memory: `image(i)` is asked for the pixels of one part after the other.
void write_exr(const std::filesystem::path& path, const std::vector<ExrPartInfo>& parts,
               const ExrAttributes& attributes, const std::function<ImageF(std::size_t)>& image);

/// A single RGB or grey image.
void write_exr(const std::filesystem::path& path, const ImageF& image);

/// Channels come as R, G, B, A and then by name. Throws FileError for anything that is not a readable EXR of flat
/// scan-line or tiled parts.
ExrFile read_exr(const std::filesystem::path& path);

/// What parts there are, without their pixels. Throws FileError likewise.
std::vector<ExrPartInfo> read_exr_parts(const std::filesystem::path& path);

/// Of a part, which is numbered, some channels in the order asked for. Throws FileError.
ExrPart read_exr_channels(const std::filesystem::path& path, int part, const std::vector<std::string>& channels);

/// The same part by part: only those that are `wanted` are read and handed to `visit`. Returns the attributes.
ExrAttributes read_exr(const std::filesystem::path& path, const std::function<bool(const std::string& part)>& wanted,
                       const std::function<void(ExrPart&&)>& visit);

}  // namespace sheen
