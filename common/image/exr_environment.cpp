// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr_environment.h"

#include <ImfEnvmap.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/errors.h"
#include "common/image/exr.h"
#include "common/image/exr_colours.h"

namespace sheen {
namespace {

constexpr int kFaces = 6;

Imath::Box2i window(int width, int height) {
  return {{0, 0}, {width - 1, height - 1}};
}

/// Of a face by itself, at a place in pixels of the whole map: no neighbour of another face gets in.
void sample_face(const ImageF& cube, int face, const Imath::V2f& place, float* rgb) {
  const int side = cube.width(), top = face * side;
  const auto within = [&](float value, int first) { return std::clamp(value, float(first), float(first + side - 1)); };
  const float x = within(place.x, 0), y = within(place.y, top);
  const int x0 = std::min(int(x), side - 1), y0 = std::min(int(y), top + side - 1);
  const int x1 = std::min(x0 + 1, side - 1), y1 = std::min(y0 + 1, top + side - 1);
  const float u = x - float(x0), v = y - float(y0);
  for (int c = 0; c < 3; ++c)
    rgb[c] = (1 - v) * ((1 - u) * cube.at(x0, y0, c) + u * cube.at(x1, y0, c)) +
             v * ((1 - u) * cube.at(x0, y1, c) + u * cube.at(x1, y1, c));
}

ImageF from_cube(const ImageF& cube) {
  const int side = cube.width();
  ImageF map(4 * side, 2 * side, 3);
  const Imath::Box2i faces = window(side, kFaces * side), sphere = window(map.width(), map.height());
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      const Imath::V3f direction = Imf::LatLongMap::direction(sphere, Imath::V2f(float(x), float(y)));
      Imf::CubeMapFace face;
      Imath::V2f in_face;
      Imf::CubeMap::faceAndPixelPosition(direction, faces, face, in_face);
      sample_face(cube, face, Imf::CubeMap::pixelPosition(face, faces, in_face), map.pixel(x, y));
    }
  return map;
}

std::string size_of(const ImageF& image) {
  return std::to_string(image.width()) + " x " + std::to_string(image.height()) + " pixels";
}

}  // namespace

ImageF read_exr_environment(const std::filesystem::path& path) {
  const ExrFile file = read_exr(path);
  const auto part = std::find_if(file.parts.begin(), file.parts.end(), [](const ExrPart& candidate) {
    return candidate.channels.size() >= 3 && candidate.channels[0] == "R" && candidate.channels[1] == "G" &&
           candidate.channels[2] == "B";
  });
  if (part == file.parts.end()) throw FileError(path.string(), "has no part with the channels R, G, B");
  ImageF radiance(part->image.width(), part->image.height(), 3);
  const int channels = part->image.channels();
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    radiance.data()[i] = part->image.data()[i / 3 * static_cast<std::size_t>(channels) + i % 3];
    if (!std::isfinite(radiance.data()[i]))
      throw FileError(path.string(), "has a pixel that is not finite: " + std::to_string(i / 3));
  }
  try {
    to_srgb_primaries(file.attributes, radiance);
  } catch (const Error& error) {
    throw FileError(path.string(), error.what());
  }
  const auto kind = file.attributes.find("envmap");
  if (kind != file.attributes.end() && kind->second == "cube") {
    if (radiance.height() != kFaces * radiance.width())
      throw FileError(path.string(), "says that it is a map of cube faces (envmap), but is " + size_of(radiance) +
                                         ": six square faces stand one below the other");
    return from_cube(radiance);
  }
  if (kind == file.attributes.end() && radiance.width() != 2 * radiance.height())
    throw FileError(path.string(), "is " + size_of(radiance) +
                                       ": a map of latitude and longitude is twice as wide as high; one of cube faces "
                                       "must say so (attribute envmap; exrenvmap writes it)");
  return radiance;
}

}  // namespace sheen
