// SPDX-License-Identifier: Apache-2.0
// What eyes see that stand where no camera stood: models of one ring of cameras, looked at from all round.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/files/compact_file.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

constexpr double kFromCentre = 0.5, kRadius = 0.09;

Eigen::Vector3d eye_at(double elevation_deg, double azimuth_deg) {
  const double up = elevation_deg * M_PI / 180, round = azimuth_deg * M_PI / 180;
  return kFromCentre * Eigen::Vector3d(std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up));
}

struct Ring {
  std::string name;
  int cameras = 0;
  double elevation_deg = 0, arc_deg = 360;

  std::vector<Eigen::Vector3d> eyes() const {
    std::vector<Eigen::Vector3d> eyes;
    for (int i = 0; i < cameras; ++i) eyes.push_back(eye_at(elevation_deg, arc_deg * i / cameras));
    return eyes;
  }
};

/// A texture in which three lamps are mirrored.
analytic::Radiance glossy() {
  return analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d& to_eye) {
    const Eigen::Vector3d n = p.normalized(), mirrored = 2 * n.dot(to_eye) * n - to_eye;
    double lamps = 0;
    for (const Eigen::Vector3d& lamp :
         {Eigen::Vector3d(1, 0, 1), Eigen::Vector3d(-1, 1, 0.3), Eigen::Vector3d(0, -1, 0.1)})
      lamps += std::pow(std::max(0.0, mirrored.dot(lamp.normalized())), 15);
    return Eigen::Vector3d((0.7 * analytic::waves(p, 0.05).array() + 0.35 * lamps).min(1.0));
  });
}

Eigen::Vector3f encode(const Eigen::Vector3f& linear) {
  return linear.unaryExpr([](float v) { return srgb_encode(v); });
}

/// A triangle's middle.
struct Place {
  Eigen::Vector3d point, normal;
  double cosine(const Eigen::Vector3d& eye) const { return normal.dot((eye - point).normalized()); }
};
Place place(const Mesh& mesh, std::size_t t) {
  const Eigen::Vector3f sum = mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2);
  return {sum.cast<double>() / 3, mesh.area_normal(t).normalized().cast<double>()};
}
Eigen::Vector3f shown(const ViewShader& shader, std::size_t t) {
  return encode(shader.shade(static_cast<std::uint32_t>(t), 1 / 3.f, 1 / 3.f).rgb);
}

/// The colours, sRGB-encoded, that cameras truly saw of a place: none where no camera saw it well.
struct SeenRange {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  bool well = false;

  float excess(const Eigen::Vector3f& colour) const {
    return std::max((low - colour).maxCoeff(), (colour - high).maxCoeff());
  }
};
SeenRange seen_range(const analytic::Scene& scene, const Place& at, const std::vector<Eigen::Vector3d>& cameras) {
  constexpr double kGrazing = 0.05, kWell = 0.3;  // cosines
  const Eigen::Vector3d point = kRadius * at.point.normalized();
  SeenRange range;
  for (const Eigen::Vector3d& camera : cameras) {
    if (at.cosine(camera) < kGrazing) continue;
    const Eigen::Vector3f colour = encode(scene.radiance(point, (camera - point).normalized()).cast<float>());
    range.low = range.low.cwiseMin(colour);
    range.high = range.high.cwiseMax(colour);
    range.well |= at.cosine(camera) > kWell;
  }
  return range;
}

/// In grey levels: by how much colours leave the range of what was seen, and change with a degree that the eye moves.
struct Walk {
  std::vector<float> excess, flicker;

  static float quantile(std::vector<float>& values, double part) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  }
};

/// Over the whole sphere.
Walk walk(const ModelSnapshot& model, const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& cameras) {
  const Mesh& mesh = model.mesh();
  std::vector<Place> places;
  std::vector<SeenRange> ranges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    places.push_back(place(mesh, t));
    ranges.push_back(seen_range(scene, places.back(), cameras));
  }
  Walk walk;
  for (double elevation = -88; elevation <= 88; elevation += 11)
    for (double azimuth = 3; azimuth < 360; azimuth += 45) {
      const Eigen::Vector3d eye = eye_at(elevation, azimuth);
      const auto here = model.shader_for({eye}), beside = model.shader_for({eye_at(elevation + 1, azimuth)});
      for (std::size_t t = 0; t < places.size(); t += 3) {
        if (!ranges[t].well || places[t].cosine(eye) < 0.05) continue;
        const Eigen::Vector3f colour = shown(*here, t);
        walk.excess.push_back(255 * ranges[t].excess(colour));
        walk.flicker.push_back(255 * (shown(*beside, t) - colour).cwiseAbs().maxCoeff());
      }
    }
  return walk;
}

class BeyondViews : public ::testing::TestWithParam<Ring> {
 protected:
  void expect_calm(const ModelSnapshot& model, const std::string& kind) const {
    Walk w = walk(model, scene_, GetParam().eyes());
    ASSERT_GT(w.excess.size(), 1000u);
    EXPECT_LT(Walk::quantile(w.excess, 0.99), 12) << kind;
    EXPECT_LT(Walk::quantile(w.excess, 1), 32) << kind;
    EXPECT_LT(Walk::quantile(w.flicker, 1), 6) << kind;
  }

  Object object_ = sphere_object();
  analytic::Scene scene_{object_.surface, glossy()};
  TempFolder temp_;
};

TEST_P(BeyondViews, ColoursStayWithinWhatWasSeenAndChangeSmoothly) {
  SurfaceLightField model(object_.mesh, plain_options());
  ingest_all(model, captures(scene_, GetParam().eyes()));
  const auto live = model.light_field_snapshot()->filled();
  expect_calm(*live, "live");
  live->save(temp_.path() / "folder", {}, {});
  expect_calm(*load_model(temp_.path() / "folder"), "saved");
  const auto small = live->compressed({.loss_db = 0.1}).snapshot;
  small->save(temp_.path() / "file", {}, {});
  expect_calm(*load_compact(temp_.path() / "file"), "small");
}

INSTANTIATE_TEST_SUITE_P(Rings, BeyondViews,
                         ::testing::Values(Ring{"OneCamera", 1, 20}, Ring{"ThreeCameras", 3, 20},
                                           Ring{"SixCameras", 6, 20}, Ring{"Low", 48, 5}, Ring{"High", 60, 60},
                                           Ring{"Middle", 24, 20}, Ring{"ShortArc", 12, 40, 60}),
                         [](const auto& ring) { return ring.param.name; });

}  // namespace
}  // namespace sheen
