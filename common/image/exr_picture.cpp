// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr_picture.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <optional>

#include "common/base/errors.h"
#include "common/image/exr.h"
#include "common/image/exr_colours.h"

namespace sheen {
namespace {

/// Channels of a part that have the part of their name before the last dot in common.
struct Layer {
  int part = 0;
  std::string name;                   ///< with the part's name, where there are several parts
  std::string prefix;                 ///< of the channels: "ViewLayer.Combined."
  std::vector<std::string> channels;  ///< without it
  bool has(const std::string& channel) const {
    return std::find(channels.begin(), channels.end(), channel) != channels.end();
  }
  bool has_colours() const { return has("R") && has("G") && has("B"); }
  /// Luminance; not the Y of a vector, and no depth.
  bool is_grey() const { return channels.size() == 1 ? !has("Z") : has("Y") && !has("X"); }
};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

std::string name_of(const std::string& part, const std::string& prefix) {
  const std::string layer = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1);
  if (part.empty() || layer.starts_with(part)) return layer;
  return layer.empty() ? part : part + "." + layer;
}

std::vector<Layer> layers_of(const std::vector<ExrPartInfo>& parts) {
  std::vector<Layer> layers;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto first = static_cast<std::ptrdiff_t>(layers.size());
    for (const std::string& channel : parts[p].channels) {
      const std::size_t dot = channel.rfind('.');
      const std::string prefix = dot == std::string::npos ? "" : channel.substr(0, dot + 1);
      auto layer =
          std::find_if(layers.begin() + first, layers.end(), [&](const Layer& l) { return l.prefix == prefix; });
      if (layer == layers.end())
        layer = layers.insert(
            layer, {static_cast<int>(p), name_of(parts.size() > 1 ? parts[p].name : "", prefix), prefix, {}});
      layer->channels.push_back(channel.substr(prefix.size()));
    }
  }
  return layers;
}

/// The smaller, the more likely is a layer of that name the finished picture; empty: it is not by its name.
std::optional<int> rank_of(const std::string& name) {
  constexpr std::array kFinished = {"composite", "combined", "beauty", "rgba", "rgb", "color", "colour", "final"};
  const std::string words = lower(name), last = words.substr(words.rfind('.') + 1);
  if (words.starts_with("composite.")) return 0;
  const auto found = std::find(kFinished.begin(), kFinished.end(), last);
  if (found == kFinished.end()) return std::nullopt;
  return static_cast<int>(found - kFinished.begin());
}

std::string list_of(const std::vector<Layer>& layers) {
  constexpr std::size_t kShown = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(layers.size(), kShown); ++i) {
    list += (i == 0 ? "" : ", ") + (layers[i].name.empty() ? "(no layer)" : layers[i].name) + " (";
    for (const std::string& channel : layers[i].channels)
      list += (&channel == &layers[i].channels.front() ? "" : " ") + channel;
    list += ")";
  }
  return layers.size() > kShown ? list + " and " + std::to_string(layers.size() - kShown) + " others" : list;
}

/// The one that is the picture. Throws FileError where that is open.
Layer picture_layer(const std::filesystem::path& path, const std::vector<Layer>& layers) {
  std::vector<const Layer*> coloured;
  for (const Layer& layer : layers)
    if (layer.has_colours()) coloured.push_back(&layer);
  for (const Layer* layer : coloured)
    if (layer->name.empty()) return *layer;
  std::vector<const Layer*> best;
  for (const Layer* layer : coloured) {
    const auto rank = rank_of(layer->name);
    if (!rank || (!best.empty() && *rank > *rank_of(best[0]->name))) continue;
    if (!best.empty() && *rank < *rank_of(best[0]->name)) best.clear();
    best.push_back(layer);
  }
  if (best.size() == 1) return *best[0];
  if (layers.size() == 1 && (layers[0].has_colours() || layers[0].is_grey())) return layers[0];
  for (const Layer& layer : layers)
    if (coloured.empty() && layer.name.empty() && layer.is_grey()) return layer;
  throw FileError(path.string(),
                  (best.size() > 1 ? "more than one of its layers may be the picture"
                                   : "none of its layers is a picture by its name (R, G, B without a layer, or a layer "
                                     "that is called Combined or beauty)") +
                      std::string("; write only the one to use. Its layers: ") + list_of(layers));
}

/// What of a layer makes the picture: red, green and blue, and alpha where there is one.
std::vector<std::string> channels_of(const Layer& layer) {
  std::vector<std::string> channels;
  if (layer.has_colours())
    channels = {"R", "G", "B"};
  else
    channels = {layer.has("Y") ? "Y" : layer.channels.front()};
  if (layer.has("A") && channels.front() != "A") channels.push_back("A");
  for (std::string& channel : channels) channel = layer.prefix + channel;
  return channels;
}

void check_size(const std::filesystem::path& path, const ImageSize& picture, const ImageF& data) {
  constexpr double kMostPixels = 1 << 26;
  const double pixels = double(picture.width) * picture.height;
  if (pixels > std::max(kMostPixels, 4.0 * data.width() * data.height()))
    throw FileError(path.string(), "claims to be part of a picture of " + std::to_string(picture.width) + " x " +
                                       std::to_string(picture.height) + " pixels");
}

void use_srgb_primaries(const std::filesystem::path& path, ImageF& image) {
  const auto none = [](const std::string&) { return false; };
  try {
    to_srgb_primaries(read_exr(path, none, [](ExrPart&&) {}), image);
  } catch (const FileError&) {
    throw;
  } catch (const Error& error) {
    throw FileError(path.string(), error.what());
  }
}

std::uint8_t byte_of(float alpha) {
  return alpha > 0 ? static_cast<std::uint8_t>(std::min(255.0f, 255 * alpha + 0.5f)) : 0;
}

/// The part's pixels at their places in the picture.
MaskedImage placed(const ExrPart& part) {
  const auto [width, height] = part.picture;
  RawImage raw;
  raw.format = PixelFormat::kRGB32f;
  raw.transfer = Transfer::kLinear;
  raw.width = width;
  raw.height = height;
  raw.stride = std::size_t(width) * 3 * sizeof(float);
  raw.bytes.resize(raw.stride * std::size_t(height));
  ImageU8 alpha(width, height, 1);
  const int channels = part.image.channels();
  const bool grey = channels < 3, has_alpha = channels == 2 || channels == 4;
  const int left = std::max(0, part.left), right = std::min(width, part.left + part.image.width());
  const int top = std::max(0, part.top), bottom = std::min(height, part.top + part.image.height());
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      const float* pixel = part.image.pixel(x - part.left, y - part.top);
      const float covered = has_alpha ? pixel[channels - 1] : 1;
      const float undo = covered > 0 && covered < 1 ? 1 / covered : 1;
      float rgb[3];
      for (int c = 0; c < 3; ++c) rgb[c] = undo * pixel[grey ? 0 : c];
      std::memcpy(raw.bytes.data() + std::size_t(y) * raw.stride + std::size_t(x) * sizeof rgb, rgb, sizeof rgb);
      alpha.at(x, y) = byte_of(covered);
    }
  return {std::move(raw), mask_of_alpha(alpha)};
}

}  // namespace

MaskedImage read_exr_picture(const std::filesystem::path& path) {
  const Layer layer = picture_layer(path, layers_of(read_exr_parts(path)));
  ExrPart part = read_exr_channels(path, layer.part, channels_of(layer));
  check_size(path, part.picture, part.image);
  use_srgb_primaries(path, part.image);
  return placed(part);
}

ImageSize read_exr_picture_size(const std::filesystem::path& path) {
  const std::vector<ExrPartInfo> parts = read_exr_parts(path);
  return parts[static_cast<std::size_t>(picture_layer(path, layers_of(parts)).part)].picture;
}

}  // namespace sheen
