// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/image/color.h"
#include "reconstructor/models/model_snapshot.h"
#include "tests/support/analytic_scene.h"

// A ball of 9 cm seen by few cameras, and looked at from all round, half a metre from its middle.
namespace sheen::beyond_views {

inline constexpr double kFromCentre = 0.5, kRadius = 0.09;

inline Eigen::Vector3d eye_at(double elevation_deg, double azimuth_deg) {
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

inline Eigen::Vector3f encode(const Eigen::Vector3f& linear) {
  return linear.unaryExpr([](float v) { return srgb_encode(v); });
}

/// A triangle's middle.
struct Place {
  Eigen::Vector3d point, normal;
  double cosine(const Eigen::Vector3d& eye) const { return normal.dot((eye - point).normalized()); }
};
inline Place place(const Mesh& mesh, std::size_t t) {
  const Eigen::Vector3f sum = mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2);
  return {sum.cast<double>() / 3, mesh.area_normal(t).normalized().cast<double>()};
}
inline Eigen::Vector3f shown(const ViewShader& shader, std::size_t t) {
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
inline SeenRange seen_range(const analytic::Scene& scene, const Place& at,
                            const std::vector<Eigen::Vector3d>& cameras) {
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

struct WalkOptions {
  LightState light;        ///< in which the scene looks as it does
  double slanting = 0.05;  ///< cosine: what the eye sees more slantingly is not judged
  std::function<bool(const Place&)> counts = [](const Place&) { return true; };  ///< whether a place is judged
};

/// Over the whole sphere.
inline Walk walk(const ModelSnapshot& model, const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& cameras,
                 const WalkOptions& options = {}) {
  const Mesh& mesh = model.mesh();
  std::vector<Place> places;
  std::vector<SeenRange> ranges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    places.push_back(place(mesh, t));
    ranges.push_back(seen_range(scene, places.back(), cameras));
    ranges.back().well &= options.counts(places.back());
  }
  Walk walk;
  for (double elevation = -88; elevation <= 88; elevation += 11)
    for (double azimuth = 3; azimuth < 360; azimuth += 45) {
      const Eigen::Vector3d eye = eye_at(elevation, azimuth);
      const auto here = model.shader_for({eye, options.light}),
                 beside = model.shader_for({eye_at(elevation + 1, azimuth), options.light});
      for (std::size_t t = 0; t < places.size(); t += 3) {
        if (!ranges[t].well || places[t].cosine(eye) < options.slanting) continue;
        const Eigen::Vector3f colour = shown(*here, t);
        walk.excess.push_back(255 * ranges[t].excess(colour));
        walk.flicker.push_back(255 * (shown(*beside, t) - colour).cwiseAbs().maxCoeff());
      }
    }
  return walk;
}

}  // namespace sheen::beyond_views
