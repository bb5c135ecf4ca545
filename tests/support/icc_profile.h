// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace sheen {

/// X, Y and Z of red, green and blue with respect to D50.
using Primaries = std::array<std::array<double, 3>, 3>;
constexpr Primaries kSrgb{{{0.43607, 0.22249, 0.01392}, {0.38515, 0.71687, 0.09708}, {0.14307, 0.06061, 0.71410}}};
constexpr Primaries kDisplayP3{
    {{0.51512, 0.24120, -0.00105}, {0.29198, 0.69225, 0.04189}, {0.15710, 0.06657, 0.78407}}};
constexpr Primaries kAdobeRgb{{{0.60974, 0.31111, 0.01947}, {0.20528, 0.62567, 0.06087}, {0.14919, 0.06322, 0.74457}}};

inline std::string big_endian(std::size_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text.push_back(static_cast<char>(value >> 8 * i));
  return text;
}
/// s15Fixed16 of the ICC's specification.
inline std::string fixed(double value) {
  return big_endian(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536))), 4);
}

inline std::string parametric_srgb() {
  std::string curve = "para" + big_endian(0, 4) + big_endian(3, 2) + big_endian(0, 2);
  for (const double value : {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045}) curve += fixed(value);
  return curve;
}
inline std::string power_curve(double gamma) {
  return "curv" + big_endian(0, 4) + big_endian(1, 4) + big_endian(std::size_t(std::lround(gamma * 256)), 2);
}
inline std::string sampled_srgb(std::size_t samples) {
  std::string curve = "curv" + big_endian(0, 4) + big_endian(samples, 4);
  for (std::size_t i = 0; i < samples; ++i) {
    const double x = double(i) / double(samples - 1);
    const double light = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    curve += big_endian(std::size_t(std::lround(65535 * light)), 2);
  }
  return curve;
}

/// A profile of three primaries and one curve for all, its name as version 2 has it.
inline std::string icc_profile(const std::string& name, const Primaries& primaries, const std::string& curve) {
  struct Tag {
    std::string signature, content;
  };
  std::vector<Tag> tags{{"desc", "desc" + big_endian(0, 4) + big_endian(name.size() + 1, 4) + name + '\0'}};
  const std::array<std::string, 3> colours{"r", "g", "b"};
  for (std::size_t i = 0; i < 3; ++i) {
    std::string xyz = "XYZ " + big_endian(0, 4);
    for (const double value : primaries[i]) xyz += fixed(value);
    tags.push_back({colours[i] + "XYZ", xyz});
    tags.push_back({colours[i] + "TRC", curve});
  }
  std::string header(128, '\0'), table = big_endian(tags.size(), 4), contents;
  header.replace(16, 8, "RGB XYZ ");
  const std::size_t first = header.size() + 4 + 12 * tags.size();
  for (const Tag& tag : tags) {
    table += tag.signature + big_endian(first + contents.size(), 4) + big_endian(tag.content.size(), 4);
    contents += tag.content;
  }
  return header + table + contents;
}

/// The segment of a JPEG file that holds it, of one part.
inline std::string jpeg_profile(const std::string& profile) {
  const std::string content = std::string("ICC_PROFILE\0\1\1", 14) + profile;
  return "\xff\xe2" + big_endian(content.size() + 2, 2) + content;
}

}  // namespace sheen
