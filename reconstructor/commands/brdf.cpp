// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/brdf.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_fields.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

constexpr const char* kHowToGetOne =
    "--brdf names a file that the user guide describes, or a table of the MERL database";

/// Throws ConfigError.
std::vector<ReflectanceLobe> lobes_of(const std::string& words, std::string_view rest) {
  const auto fail = [&]() -> double {
    throw ConfigError(
        "--brdf takes a file, lambertian, lafortune:K or lafortune:B:K,B:K... (weights B above 0, exponents K of 0, 1 "
        "or 2 to 100000), not " +
        words);
  };
  const auto number = [&](std::string_view word) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() ? value : fail();
  };
  std::vector<ReflectanceLobe> lobes;
  for (;;) {
    const std::string_view lobe = rest.substr(0, rest.find(','));
    const std::size_t colon = lobe.find(':');
    const double weight = colon == std::string_view::npos ? 1 : number(lobe.substr(0, colon)),
                 exponent = number(lobe.substr(colon == std::string_view::npos ? 0 : colon + 1));
    if (!(weight > 0 && weight < 1e9) || !is_lobe_exponent(exponent)) fail();
    lobes.push_back({weight, exponent});
    if (lobe.size() == rest.size()) return lobes;
    rest.remove_prefix(lobe.size() + 1);
  }
}

std::vector<double> numbers_in(const JsonFields& fields, const Json& list, const std::string& field, std::size_t least,
                               std::size_t most, double low, double high) {
  std::vector<double> numbers;
  for (const Json& value : fields.array(list, field, least, most))
    numbers.push_back(fields.number(value, field, low, high));
  return numbers;
}

std::shared_ptr<const Reflectance> parts_of(const JsonFields& fields, const Json& list) {
  std::vector<AnalyticReflectance::Lafortune> lobes;
  std::vector<AnalyticReflectance::Microfacets> microfacets;
  std::size_t index = 0;
  for (const Json& part : fields.array(list, "parts", 1, 64)) {
    const std::string where = "parts[" + std::to_string(index++) + "].";
    const auto number = [&](const char* key, double low, double high) {
      return fields.number(fields.member(part, key, where), where + key, low, high);
    };
    const double weight = part.contains("weight") ? number("weight", 1e-9, 1e9) : 1;
    if (part.contains("lambertian")) {
      lobes.push_back({.weight = number("lambertian", 1e-9, 1e9)});
    } else if (part.contains("lafortune")) {
      const std::vector<double> c = numbers_in(fields, part["lafortune"], where + "lafortune", 3, 3, -1, 1);
      lobes.push_back({.weight = weight, .c = {c[0], c[1], c[2]}, .exponent = number("exponent", 0, 1e5)});
    } else if (part.contains("ggx")) {
      microfacets.push_back(
          {.weight = weight, .normal_reflectance = number("ggx", 0, 1), .roughness = number("roughness", 0.01, 1)});
    } else {
      fields.fail(where, "must have one of lambertian, lafortune, ggx");
    }
  }
  return std::make_shared<AnalyticReflectance>(std::move(lobes), std::move(microfacets));
}

std::shared_ptr<const Reflectance> table_of(const JsonFields& fields, const Json& table) {
  using Coordinates = TabulatedReflectance::Coordinates;
  const std::string coordinates = fields.text(fields.member(table, "coordinates", "table."), "table.coordinates");
  if (coordinates != "light_eye" && coordinates != "half_difference")
    fields.fail("table.coordinates", "must be \"light_eye\" or \"half_difference\"");
  std::array<std::vector<double>, 3> axes;
  const Json& angles = fields.array(fields.member(table, "angles_deg", "table."), "table.angles_deg", 3, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = numbers_in(fields, angles[i], "table.angles_deg", 2, 1000, 0, 180);
    for (double& angle : axes[i]) angle *= kDegree;
  }
  std::vector<float> values;
  for (const double value :
       numbers_in(fields, fields.member(table, "values", "table."), "table.values", 8, 1 << 24, -1e9, 1e9))
    values.push_back(static_cast<float>(value));
  const double resolution =
      table.contains("resolution_deg") ? fields.number(table["resolution_deg"], "table.resolution_deg", 0.01, 10) : 1;
  return std::make_shared<TabulatedReflectance>(
      coordinates == "light_eye" ? Coordinates::kLightEye : Coordinates::kHalfDifference, std::move(axes),
      std::move(values), resolution * kDegree);
}

Brdf read_json(const std::filesystem::path& path) {
  const JsonFields fields(path);
  const Json file = fields.open("sheen brdf", 1, kHowToGetOne);
  try {
    if (file.contains("parts") == file.contains("table")) fields.fail("parts", "or \"table\" must be there, not both");
    return {{file.contains("parts") ? parts_of(fields, file["parts"]) : table_of(fields, file["table"])}, {}};
  } catch (const std::invalid_argument& error) {
    throw FileError(path.string(), error.what());
  }
}

// The MERL database (Matusik et al. 2003): three counts of 32 bits, then doubles: for each of red, green and blue, for
// each angle of the half vector, of the light to it and of that azimuth one value; less than 0 where there is none.
constexpr std::size_t kMerlHalf = 90, kMerlDifference = 90, kMerlAzimuth = 180;
constexpr std::array kMerlScales{1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
constexpr double kMerlResolution = 1 * kDegree;

Brdf read_merl(const std::filesystem::path& path, const std::string& bytes) {
  constexpr std::size_t kValues = kMerlHalf * kMerlDifference * kMerlAzimuth;
  std::array<std::int32_t, 3> counts{};
  if (bytes.size() >= sizeof counts) std::memcpy(counts.data(), bytes.data(), sizeof counts);
  if (counts != std::array<std::int32_t, 3>{kMerlHalf, kMerlDifference, kMerlAzimuth} ||
      bytes.size() != sizeof counts + kMerlScales.size() * kValues * sizeof(double))
    throw FileError(path.string(), std::string("is neither JSON nor a table of 90 x 90 x 180 values; ") + kHowToGetOne);
  std::array<std::vector<double>, 3> axes;
  for (std::size_t i = 0; i < kMerlHalf; ++i) {  // denser round the highlight
    const double part = static_cast<double>(i) / kMerlHalf;
    axes[0].push_back(90 * kDegree * part * part);
  }
  for (std::size_t i = 0; i < kMerlDifference; ++i) axes[1].push_back(static_cast<double>(i) * kDegree);
  for (std::size_t i = 0; i < kMerlAzimuth; ++i) axes[2].push_back(static_cast<double>(i) * kDegree);
  Brdf brdf;
  for (std::size_t channel = 0; channel < kMerlScales.size(); ++channel) {
    std::vector<float> values(kValues);
    for (std::size_t i = 0; i < kValues; ++i) {
      double value = 0;
      std::memcpy(&value, bytes.data() + sizeof counts + (channel * kValues + i) * sizeof value, sizeof value);
      if (!std::isfinite(value)) throw FileError(path.string(), "holds a value that is not finite");
      values[i] = static_cast<float>(value * kMerlScales[channel]);
    }
    try {
      brdf.channels.push_back(std::make_shared<TabulatedReflectance>(TabulatedReflectance::Coordinates::kHalfDifference,
                                                                     axes, std::move(values), kMerlResolution));
    } catch (const std::invalid_argument& error) {
      throw FileError(path.string(), error.what());
    }
  }
  return brdf;
}

}  // namespace

Brdf parse_brdf(const std::string& words) {
  constexpr std::string_view kLafortune = "lafortune:";
  const bool lafortune = std::string_view(words).starts_with(kLafortune);
  if (words == "lambertian" || lafortune || !std::filesystem::exists(words)) {
    const std::vector<ReflectanceLobe> lobes =
        words == "lambertian" ? std::vector<ReflectanceLobe>{{}}
                              : lobes_of(words, lafortune ? std::string_view(words).substr(kLafortune.size()) : "");
    return {{std::make_shared<FreeLobes>(lobes)}, lobe_bounds(lobes)};
  }
  constexpr std::size_t kMostBytes = std::size_t{1} << 28;
  const std::string bytes = read_file(words, kMostBytes);
  return bytes.starts_with('{') ? read_json(words) : read_merl(words, bytes);
}

}  // namespace sheen
