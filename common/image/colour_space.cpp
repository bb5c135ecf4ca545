// SPDX-License-Identifier: Apache-2.0
#include "common/image/colour_space.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/image/exif.h"
#include "common/image/image_blocks.h"

namespace sheen {
namespace {

constexpr std::size_t kMostProfileBytes = 4u << 20;
constexpr double kHalfOfSrgb = 0.2140;  ///< what an encoded half is in linear light
constexpr double kNear = 0.012;         ///< of 1: primaries and curves of the sRGB profiles in use differ by less

/// A profile as the ICC's specification lays it out (ICC.1, sections 7 and 10): a header of 128 bytes, then a table of
/// tags, each a signature, a place and a size.
class IccProfile {
 public:
  explicit IccProfile(std::string_view data) : data_(data), integers_(data, /*big_endian=*/true) {}

  bool is_rgb() const { return data_.size() > 128 && data_.substr(16, 4) == "RGB "; }
  std::string name() const;
  /// X, Y and Z of a colour's light, with respect to D50.
  std::optional<std::array<double, 3>> primary(std::string_view tag) const;
  /// What an encoded half is in linear light.
  std::optional<double> half(std::string_view tag) const;

 private:
  std::string_view tag(std::string_view signature) const;
  static double fixed(std::uint32_t value) { return static_cast<std::int32_t>(value) / 65536.0; }

  std::string_view data_;
  Integers integers_;
};

std::string_view IccProfile::tag(std::string_view signature) const {
  const auto count = integers_.at(128, 4);
  for (std::size_t i = 0; count && i < std::min(*count, 200u); ++i) {
    const auto place = integers_.at(136 + 12 * i, 4), size = integers_.at(140 + 12 * i, 4);
    if (!place || !size) return {};
    if (data_.substr(132 + 12 * i, 4) == signature && *place <= data_.size()) return data_.substr(*place, *size);
  }
  return {};
}

std::string IccProfile::name() const {
  const std::string_view text = tag("desc");
  const Integers integers(text, /*big_endian=*/true);
  std::string name;
  if (text.starts_with("desc")) {
    name = text.substr(std::min<std::size_t>(12, text.size()), integers.at(8, 4).value_or(0));
  } else if (text.starts_with("mluc")) {  // of the first language, in UTF-16
    const std::size_t size = integers.at(20, 4).value_or(0), place = integers.at(24, 4).value_or(0);
    for (std::size_t i = 1; i < size && place + i < text.size(); i += 2) name += text[place + i];
  }
  std::erase_if(name, [](unsigned char c) { return c < ' ' || c > '~'; });
  constexpr std::size_t kLength = 60;
  return name.substr(0, kLength);
}

std::optional<std::array<double, 3>> IccProfile::primary(std::string_view signature) const {
  const std::string_view content = tag(signature);
  const Integers integers(content, /*big_endian=*/true);
  const auto x = integers.at(8, 4), y = integers.at(12, 4), z = integers.at(16, 4);
  if (!content.starts_with("XYZ ") || !x || !y || !z) return std::nullopt;
  return std::array{fixed(*x), fixed(*y), fixed(*z)};
}

std::optional<double> IccProfile::half(std::string_view signature) const {
  const std::string_view content = tag(signature);
  const Integers integers(content, /*big_endian=*/true);
  if (content.starts_with("curv")) {
    const auto count = integers.at(8, 4);
    if (!count) return std::nullopt;
    if (*count == 0) return 0.5;
    const auto value = integers.at(12 + 2 * (std::size_t(*count - 1) / 2), 2);
    if (!value) return std::nullopt;
    return *count == 1 ? std::pow(0.5, *value / 256.0) : *value / 65535.0;
  }
  if (!content.starts_with("para")) return std::nullopt;
  std::array<double, 7> p{};  // g, a, b, c, d, e, f
  const auto type = integers.at(8, 2);
  constexpr std::array<std::size_t, 5> kCounts{1, 3, 4, 5, 7};
  if (!type || *type >= kCounts.size()) return std::nullopt;
  for (std::size_t i = 0; i < kCounts[*type]; ++i) {
    const auto value = integers.at(12 + 4 * i, 4);
    if (!value) return std::nullopt;
    p[i] = fixed(*value);
  }
  if (*type == 0) return std::pow(0.5, p[0]);
  const double offset = *type == 2 ? p[3] : *type == 4 ? p[5] : 0;
  return std::pow(std::max(0.0, p[1] * 0.5 + p[2]), p[0]) + offset;
}

bool is_srgb(const IccProfile& profile) {
  const std::array<std::array<double, 3>, 3> srgb{
      {{0.4360, 0.2225, 0.0139}, {0.3851, 0.7169, 0.0971}, {0.1431, 0.0606, 0.7141}}};  // with respect to D50
  const std::array<const char*, 3> primaries{"rXYZ", "gXYZ", "bXYZ"}, curves{"rTRC", "gTRC", "bTRC"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto primary = profile.primary(primaries[i]);
    const auto half = profile.half(curves[i]);
    if (!primary || !half)
      return profile.name().find("sRGB") != std::string::npos;  // by tables: nothing but its name tells
    if (std::abs(*half - kHalfOfSrgb) > kNear) return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (std::abs((*primary)[k] - srgb[i][k]) > kNear) return false;
  }
  return true;
}

/// Of iCCP: a name, a zero, the method of compression, the profile.
std::string unpacked(std::string_view chunk) {
  const std::size_t name = chunk.find('\0');
  if (name == std::string_view::npos || name + 2 > chunk.size()) return {};
  chunk.remove_prefix(name + 2);
  std::string profile(kMostProfileBytes, '\0');
  uLongf size = profile.size();
  if (uncompress(reinterpret_cast<Bytef*>(profile.data()), &size, reinterpret_cast<const Bytef*>(chunk.data()),
                 chunk.size()) != Z_OK)
    return {};
  profile.resize(size);
  return profile;
}

std::string icc_profile(std::string_view file) {
  if (const auto in_png = png_chunk(file, "iCCP"); !in_png.empty()) return unpacked(in_png);
  if (const auto in_webp = webp_chunk(file, "ICCP"); !in_webp.empty()) return std::string(in_webp);
  std::string_view in_jpeg = jpeg_segment(file, 0xFFE2, std::string_view("ICC_PROFILE\0", 12));
  in_jpeg.remove_prefix(
      std::min<std::size_t>(2, in_jpeg.size()));  // which part of how many: names and primaries are in the first
  return std::string(in_jpeg);
}

/// By gAMA and cHRM, in hundred-thousandths.
bool png_says_other_colours(std::string_view file) {
  if (!png_chunk(file, "sRGB").empty()) return false;
  if (const auto gamma = Integers(png_chunk(file, "gAMA"), /*big_endian=*/true).at(0, 4))
    if (std::abs(int(*gamma) - 45455) > 2000) return true;
  const std::array<int, 8> srgb{31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};
  const Integers chromaticities(png_chunk(file, "cHRM"), /*big_endian=*/true);
  for (std::size_t i = 0; i < srgb.size(); ++i)
    if (const auto value = chromaticities.at(4 * i, 4))
      if (std::abs(double(*value) - srgb[i]) > 1e5 * kNear) return true;
  return false;
}

}  // namespace

std::string other_colour_space(std::string_view file) {
  const std::string bytes = icc_profile(file);
  if (const IccProfile profile(bytes); profile.is_rgb()) {
    if (is_srgb(profile)) return {};
    const std::string name = profile.name();
    return name.empty() ? "that of an ICC profile without a name" : name;
  }
  if (png_says_other_colours(file)) return "that of its gAMA or cHRM chunk";
  if (bytes.empty() && exif_says_other_colours(file)) return "not sRGB, as EXIF says";
  return {};
}

}  // namespace sheen
