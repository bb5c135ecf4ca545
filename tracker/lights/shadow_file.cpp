// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/shadow_file.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "common/base/json_fields.h"
#include "common/geometry/ray_scene.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
constexpr double kFarthest = 1e6;

double unit_of(const JsonFields& fields, const Json& file) {
  const std::string unit = file.contains("unit") ? fields.text(file["unit"], "unit") : "m";
  if (unit == "m") return 1;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  fields.fail("unit", "must be \"m\", \"cm\" or \"mm\"");
}

ClickedPoint read_point(const JsonFields& fields, const Json& pair, const std::string& where, const char* key,
                        double unit) {
  const std::string field = where + key;
  const Json& value = fields.array(fields.member(pair, key, where), field, 2, 3);
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < value.size(); ++i)
    at[static_cast<int>(i)] = fields.number(value[i], field + "[" + std::to_string(i) + "]", -kFarthest, kFarthest);
  if (value.size() == 3) return {.place = unit * at};
  return {.pixel = at.head<2>()};
}

/// Where a pixel shows the mesh, and the covariance of that for a pixel's standard deviation.
struct SeenPoint {
  Eigen::Vector3d place;
  Eigen::Matrix3d covariance;
};
class SurfaceUnderPixels {
 public:
  SurfaceUnderPixels(const PosedCamera& view, const Mesh& mesh) : view_(view), mesh_(mesh), rays_(mesh) {}

  SeenPoint at(const Eigen::Vector2d& pixel, double sigma_px, const std::string& what) const {
    const auto through = view_.camera.contains(pixel) ? view_.camera.ray(pixel) : std::nullopt;
    if (!through) throw Error(what + " is a pixel outside of the image");
    const Eigen::Vector3d eye = camera_centre(view_.camera_from_object), ray = in_object(*through);
    const Hit hit = rays_.intersect({.origin = eye.cast<float>(), .direction = ray.cast<float>()});
    if (!hit) throw Error(what + " is a pixel that shows nothing of the mesh; click beside the edge, on the surface");
    const Eigen::Vector3d corner = mesh_.corner(hit.triangle, 0).cast<double>();
    const Eigen::Vector3d normal = mesh_.area_normal(hit.triangle).cast<double>().normalized();
    const auto meet = [&](const Eigen::Vector3d& way) -> Eigen::Vector3d {
      return eye + way * ((corner - eye).dot(normal) / way.dot(normal));
    };
    SeenPoint seen{meet(ray), Eigen::Matrix3d::Zero()};
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d beside = pixel;
      beside[k] += 0.01;
      const Eigen::Vector3d by = (meet(in_object(view_.camera.ray(beside).value_or(*through))) - seen.place) / 0.01;
      seen.covariance += sigma_px * sigma_px * by * by.transpose();
    }
    // A little in all directions: a covariance across the pair's line must not vanish.
    seen.covariance.diagonal().array() += 1e-4 * seen.covariance.trace();
    return seen;
  }

 private:
  Eigen::Vector3d in_object(const Eigen::Vector3d& way) const {
    return view_.camera_from_object.rotation.conjugate() * way;
  }

  const PosedCamera& view_;
  const Mesh& mesh_;
  RayScene rays_;
};

}  // namespace

bool ShadowFile::any_pixels() const {
  for (const ClickedLight& light : lights)
    for (const ClickedPair& pair : light.pairs)
      if (!pair.shadow.place || !pair.object.place) return true;
  return false;
}

ShadowFile load_shadow_file(const std::filesystem::path& path) {
  const JsonFields fields(path);
  const Json file = fields.open("sheen-shadows", 1, "the user guide shows such a file under \"Light that moves\"");
  const double unit = unit_of(fields, file);
  ShadowFile read;
  if (file.contains("uncertainty"))
    read.uncertainty_m = unit * fields.number(file["uncertainty"], "uncertainty", 1e-9, kFarthest);
  if (file.contains("pixel_uncertainty"))
    read.pixel_uncertainty_px = fields.number(file["pixel_uncertainty"], "pixel_uncertainty", 1e-6, 1e4);
  const Json& lights = fields.array(fields.member(file, "lights", ""), "lights", 1, 4096);
  std::set<std::string> images;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::string where = "lights[" + std::to_string(i) + "].";
    ClickedLight light{.image = fields.text(fields.member(lights[i], "image", where), where + "image")};
    if (light.image.empty()) fields.fail(where + "image", "is empty");
    if (!images.insert(light.image).second) fields.fail(where + "image", "is \"" + light.image + "\" a second time");
    const Json& pairs = fields.array(fields.member(lights[i], "pairs", where), where + "pairs", 1, 10000);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const std::string pair = where + "pairs[" + std::to_string(k) + "].";
      light.pairs.push_back(
          {read_point(fields, pairs[k], pair, "shadow", unit), read_point(fields, pairs[k], pair, "object", unit)});
    }
    read.lights.push_back(std::move(light));
  }
  // What is known of one kind of points says nothing of the other.
  bool any_places = false;
  for (const ClickedLight& light : read.lights)
    for (const ClickedPair& pair : light.pairs) any_places |= pair.shadow.place || pair.object.place;
  if (any_places && read.any_pixels() && read.uncertainty_m.has_value() + read.pixel_uncertainty_px.has_value() < 2)
    fields.fail("uncertainty",
                "and \"pixel_uncertainty\" are both needed where some points are places and some are pixels");
  return read;
}

std::vector<ShadowPair> pairs_in_space(const ClickedLight& light, const ShadowFile& file, const PosedCamera* view,
                                       const Mesh* mesh) {
  std::optional<SurfaceUnderPixels> surface;
  if (view && mesh) surface.emplace(*view, *mesh);
  const double sigma_m = file.uncertainty_m.value_or(1), sigma_px = file.pixel_uncertainty_px.value_or(1);
  const auto in_space = [&](const ClickedPoint& point, const std::string& what) -> SeenPoint {
    if (point.place) return {*point.place, sigma_m * sigma_m * Eigen::Matrix3d::Identity()};
    return surface.value().at(point.pixel, sigma_px, light.image + ": " + what);
  };
  std::vector<ShadowPair> pairs;
  for (std::size_t i = 0; i < light.pairs.size(); ++i) {
    const std::string pair = "pair " + std::to_string(i + 1) + ": the ";
    const SeenPoint shadow = in_space(light.pairs[i].shadow, pair + "shadow"),
                    object = in_space(light.pairs[i].object, pair + "object");
    pairs.push_back({shadow.place, object.place, shadow.covariance, object.covariance});
  }
  return pairs;
}

}  // namespace sheen
