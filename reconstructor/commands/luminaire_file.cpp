// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/luminaire_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/json_fields.h"
#include "common/image/exr_environment.h"
#include "reconstructor/render/luminaires.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

constexpr int kAreaSamples = 8;  // per side
constexpr double kFarthest = 1e6, kBrightest = 1e6;

/// A lamp of the file, read field by field.
class LampReader {
 public:
  LampReader(const JsonFields& fields, const Json& lamp, std::string where)
      : fields_(fields), lamp_(lamp), where_(std::move(where)) {}

  Eigen::Vector3d vector(const Json& object, const std::string& key, const std::string& where) const {
    Eigen::Vector3d vector;
    const Json& list = fields_.array(fields_.member(object, key, where), where + key, 3, 3);
    for (int i = 0; i < 3; ++i)
      vector[i] = fields_.number(list[static_cast<std::size_t>(i)], where + key, -kFarthest, kFarthest);
    if (!(vector.norm() > 1e-9)) fields_.fail(where + key, "must not be 0 0 0");
    return vector;
  }
  Eigen::Vector3f colour() const {
    if (!lamp_.contains("rgb")) return Eigen::Vector3f::Ones();
    const Json& list = fields_.array(lamp_["rgb"], where_ + "rgb", 3, 3);
    Eigen::Vector3f rgb;
    for (int i = 0; i < 3; ++i)
      rgb[i] = static_cast<float>(fields_.number(list[static_cast<std::size_t>(i)], where_ + "rgb", 1e-9, kBrightest));
    return rgb;
  }
  std::vector<LightState> lights(std::span<const LightState> known, const std::filesystem::path& folder) const {
    if (lamp_.contains("at")) return {{LightKind::kPoint, vector(lamp_, "at", where_), colour()}};
    if (lamp_.contains("towards"))
      return {{LightKind::kDirectional, vector(lamp_, "towards", where_).normalized(), colour()}};
    if (lamp_.contains("area")) return area(known);
    if (lamp_.contains("environment")) {
      const Eigen::Vector3f rgb = colour();
      std::vector<LightState> lights =
          load_environment(folder / fields_.text(lamp_["environment"], where_ + "environment"), known).lights;
      for (LightState& light : lights) light.rgb = light.rgb.cwiseProduct(rgb);
      return lights;
    }
    fields_.fail(where_, "must have one of at, towards, area, environment");
  }

 private:
  std::vector<LightState> area(std::span<const LightState> known) const {
    const std::string where = where_ + "area.";
    const Json& area = lamp_["area"];
    const AreaLuminaire lamp{vector(area, "centre", where), vector(area, "half_u", where),
                             vector(area, "half_v", where), colour()};
    const Eigen::Vector3d normal = lamp.half_u.cross(lamp.half_v);
    if (!(normal.norm() > 1e-6 * lamp.half_u.norm() * lamp.half_v.norm()))
      fields_.fail(where + "half_v", "must not be along half_u");
    if (!(-normal.dot(lamp.centre) > 1e-6 * normal.norm() * lamp.centre.norm()))
      fields_.fail(where + "half_u", "and half_v turn the lamp away from the object; exchange them");
    return lights_of(lamp, known.front().kind, kAreaSamples);
  }

  const JsonFields& fields_;
  const Json& lamp_;
  std::string where_;
};

}  // namespace

LitPicture load_environment(const std::filesystem::path& map, std::span<const LightState> known) {
  const EnvironmentLights found = lights_of(read_exr_environment(map), known);
  if (found.left_out > 0.005)
    std::printf("%s: %.0f %% of its light comes from where the model's images had none, and is left out\n",
                map.string().c_str(), 100 * found.left_out);
  return {map.stem().string(), found.lights};
}

std::vector<LitPicture> load_luminaires(const std::filesystem::path& path, std::span<const LightState> known) {
  const JsonFields fields(path);
  const Json file = fields.open("sheen luminaires", 1, "the user guide describes it");
  std::vector<LitPicture> pictures;
  for (const Json& entry : fields.array(fields.member(file, "pictures", ""), "pictures", 1, 100'000)) {
    const std::string where = "pictures[" + std::to_string(pictures.size()) + "].";
    LitPicture picture{fields.text(fields.member(entry, "name", where), where + "name"), {}};
    if (picture.name.empty()) fields.fail(where + "name", "must not be empty");
    std::size_t index = 0;
    for (const Json& lamp : fields.array(fields.member(entry, "lights", where), where + "lights", 1, 1000)) {
      const LampReader reader(fields, lamp, where + "lights[" + std::to_string(index++) + "].");
      const std::vector<LightState> lights = reader.lights(known, path.parent_path());
      picture.lights.insert(picture.lights.end(), lights.begin(), lights.end());
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace sheen
