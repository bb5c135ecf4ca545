// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/path_tracer.h"

#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/errors.h"

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3f;

constexpr float kRayOffset = 3e-4f;      // metres; clears the facets next to a secondary ray's origin
constexpr float kGrazingCosine = 0.03f;  // a smooth normal that turns away further than this is bent back

/// Point i of n of the Hammersley set in the unit square: either coordinate alone takes n evenly spaced values, so that
/// an edge along a row or a column of pixels is resolved to 1/n of a pixel.
Eigen::Vector2f spread_point(int i, int n) {
  std::uint32_t bits = static_cast<std::uint32_t>(i), reversed = 0;
  for (int k = 0; k < 32; ++k, bits >>= 1) reversed = reversed << 1 | (bits & 1);
  return {(i + 0.5f) / n, static_cast<float>(reversed >> 8) * 0x1p-24f + 0.5f / n};
}

/// A set of points for the lobe, dealt out to the primary rays of a pixel.
class DealtPoints {
 public:
  DealtPoints(int points, int rays) : shares_(rays) {
    for (int i = 0; i < points; ++i) {
      std::vector<LobePoints>& share = shares_[i % rays];
      if (share.empty() || share.back().count == LobePoints::kCount) share.emplace_back();
      const Eigen::Vector2f u = spread_point(i, points);
      share.back().add(u.x(), u.y());
    }
  }
  std::span<const LobePoints> share(int ray) const { return shares_[ray]; }

 private:
  std::vector<std::vector<LobePoints>> shares_;
};

}  // namespace

LensRays::LensRays(const Camera& camera) : camera_(camera) {
  if (const std::string error = validation_error(camera); !error.empty()) throw ConfigError("simulation: " + error);
  corners_.resize(std::size_t(camera.width + 1) * (camera.height + 1));
  tbb::parallel_for(0, camera.height + 1, [&](int y) {
    for (int x = 0; x <= camera.width; ++x) {
      const auto ray = camera.ray({x - 0.5, y - 0.5});
      if (!ray || ray->z() <= 0.05)
        throw ConfigError("simulation: the camera's lens folds inside the image; reduce the distortion");
      corners_[std::size_t(y) * (camera.width + 1) + x] = (ray->head<2>() / ray->z()).cast<float>();
    }
  });
}

Vector3f LensRays::direction(float x, float y) const {
  const float gx = x + 0.5f, gy = y + 0.5f;
  const int x0 = std::clamp(static_cast<int>(gx), 0, camera_.width - 1);
  const int y0 = std::clamp(static_cast<int>(gy), 0, camera_.height - 1);
  const float fx = gx - x0, fy = gy - y0;
  const Eigen::Vector2f* top = &corners_[std::size_t(y0) * (camera_.width + 1) + x0];
  const Eigen::Vector2f* bottom = top + camera_.width + 1;
  const Eigen::Vector2f p = (top[0] * (1 - fx) + top[1] * fx) * (1 - fy) + (bottom[0] * (1 - fx) + bottom[1] * fx) * fy;
  return {p.x(), p.y(), 1};
}

/// The first thing along a ray. `region` is meaningless on the object.
struct PathTracer::Surface {
  Hit object;
  StageSurface::Region region = StageSurface::Region::kNothing;
  Vector3f position = Vector3f::Zero();

  bool same_kind(const Surface& other) const { return bool(object) == bool(other.object) && region == other.region; }
};

PathTracer::PathTracer(SimulatedScene scene, const BakeOptions& bake)
    : scene_(std::make_unique<SimulatedScene>(std::move(scene))),
      rays_(std::make_unique<RayScene>(scene_->object.mesh)),
      bake_(std::make_unique<LightBake>(*scene_, *rays_, bake)),
      bounds_(bounding_sphere(scene_->object.mesh)) {}

PathTracer::Surface PathTracer::first_surface(const Vector3f& origin, const Vector3f& direction) const {
  Surface surface;
  const Vector3f to_centre = bounds_.centre.cast<float>() - origin;
  const float off = to_centre.cross(direction).squaredNorm() / direction.squaredNorm();
  if (off <= float(bounds_.radius * bounds_.radius)) {
    surface.object = rays_->intersect({origin, direction});
    if (surface.object) {
      surface.position = origin + surface.object.distance * direction;
      return surface;
    }
  }
  if (scene_->stage && origin.z() > 0 && direction.z() < 0) {
    surface.position = origin - origin.z() / direction.z() * direction;
    surface.region = scene_->stage->region(surface.position.x(), surface.position.y());
  }
  return surface;
}

/// Of a surface that has this normal; zero where the lamp does not reach it. `towards`: unit direction to the lamp.
Array3f PathTracer::lamp_irradiance(const PointLamp& lamp, const Vector3f& place, const Vector3f& normal,
                                    Vector3f& towards) const {
  const Vector3f origin = place + kRayOffset * normal, way = lamp.position - origin;
  const float distance = way.norm();
  towards = way / distance;
  const float cosine = normal.dot(towards);
  if (cosine <= 0 || rays_->occluded({.origin = origin, .direction = way, .far = 1})) return Array3f::Zero();
  return lamp.power * (cosine / (distance * distance));
}

/// Radiance that a surface sends back of the lamp's light.
Array3f PathTracer::shade_by_lamp(const Surface& surface, const Vector3f& direction, const PointLamp& lamp) const {
  Vector3f towards;
  if (!surface.object) {
    if (surface.region == StageSurface::Region::kNothing) return Array3f::Zero();
    const Array3f irradiance = lamp_irradiance(lamp, surface.position, Vector3f::UnitZ(), towards);
    return scene_->stage->albedo(surface.region, surface.position.x(), surface.position.y()) * irradiance / float(M_PI);
  }
  if (!surface.object.front) return Array3f::Zero();
  const Vector3f eye = -direction.normalized(), n = shading_normal(surface.object, eye);
  const Array3f irradiance = lamp_irradiance(lamp, surface.position, n, towards);
  if (irradiance.maxCoeff() <= 0) return Array3f::Zero();
  const Material material = scene_->object.material(surface.position);
  Array3f reflected = material.albedo * (1 - lobe_albedo(material, n.dot(eye))) / float(M_PI);
  if (material.normal_reflectance.maxCoeff() > 0) {
    Eigen::Matrix3f object_from_local;
    object_from_local.col(2) = n;
    object_from_local.col(0) = n.unitOrthogonal();
    object_from_local.col(1) = n.cross(object_from_local.col(0));
    reflected += ggx(material, object_from_local.transpose() * eye, object_from_local.transpose() * towards);
  }
  return reflected * irradiance;
}

/// That of the smooth surface, bent back where it turns away from the eye.
Vector3f PathTracer::shading_normal(const Hit& hit, const Vector3f& eye) const {
  const TestObject& object = scene_->object;
  const Triangle& t = object.mesh.triangles[hit.triangle];
  const Vector3f n =
      ((1 - hit.u - hit.v) * object.normals[t[0]] + hit.u * object.normals[t[1]] + hit.v * object.normals[t[2]])
          .normalized();
  const float cosine = n.dot(eye);
  return cosine < kGrazingCosine ? (n + (kGrazingCosine - cosine) * eye).normalized() : n;
}

Array3f PathTracer::shade_object(const Hit& hit, const Vector3f& position, const Vector3f& direction,
                                 LobeShare share) const {
  if (!hit.front) return Array3f::Zero();
  const Vector3f eye = -direction.normalized(), n = shading_normal(hit, eye);
  const float eye_cosine = n.dot(eye);

  const Material material = scene_->object.material(position);
  Array3f radiance =
      material.albedo * (1 - lobe_albedo(material, eye_cosine)) * bake_->object_irradiance(hit) / float(M_PI);
  if (material.normal_reflectance.maxCoeff() <= 0 || share.empty()) return radiance;

  // The frame turns with the eye, so that the sample points move smoothly over the surface.
  Vector3f across = n.cross(eye);
  across = across.norm() > 1e-4f ? across.normalized() : n.unitOrthogonal();
  Eigen::Matrix3f object_from_local;
  object_from_local << across.cross(n), across, n;
  const Vector3f eye_local = object_from_local.transpose() * eye;
  const Vector3f origin = position + kRayOffset * n;
  Array3f sum = Array3f::Zero();
  int count = 0;
  for (const LobePoints& points : share) {
    const LobeSamples samples = sample_ggx(material.roughness, eye_local, points);
    std::array<Ray, LobePoints::kCount> rays;
    std::array<Array3f, LobePoints::kCount> weights, incoming;
    std::size_t used = 0;
    for (int i = 0; i < points.count; ++i) {
      if (samples.z[i] <= 0) continue;
      weights[used] = material.normal_reflectance * samples.scale[i] + samples.bias[i];
      rays[used++] = {origin, (object_from_local * Vector3f(samples.x[i], samples.y[i], samples.z[i])).normalized()};
    }
    bake_->incoming(std::span(rays).first(used), incoming);
    for (std::size_t i = 0; i < used; ++i) sum += weights[i] * incoming[i];
    count += points.count;
  }
  return radiance + sum / static_cast<float>(count);
}

Array3f PathTracer::shade(const Surface& surface, const Vector3f& direction, LobeShare share) const {
  if (surface.object) return shade_object(surface.object, surface.position, direction, share);
  if (surface.region == StageSurface::Region::kNothing) return scene_->lighting.environment(direction.normalized());
  const float x = surface.position.x(), y = surface.position.y();
  return scene_->stage->albedo(surface.region, x, y) * bake_->stage_irradiance(x, y) / float(M_PI);
}

Array3f PathTracer::radiance(const Vector3f& origin, const Vector3f& direction, int lobe_samples) const {
  return shade(first_surface(origin, direction), direction, DealtPoints(lobe_samples, 1).share(0));
}

RenderedView PathTracer::render(const LensRays& lens, const Rigid3& camera_from_object,
                                const RenderOptions& options) const {
  const int width = lens.camera().width, height = lens.camera().height;
  const Eigen::Matrix3f object_from_camera = camera_from_object.rotation.conjugate().toRotationMatrix().cast<float>();
  const Vector3f eye = camera_centre(camera_from_object).cast<float>();
  const auto ray_at = [&](float x, float y) -> Vector3f { return object_from_camera * lens.direction(x, y); };

  const auto lit = [&](const Surface& surface, const Vector3f& ray, LobeShare share) -> Array3f {
    const Array3f radiance = options.lighting * shade(surface, ray, share);
    return options.lamp ? Array3f(radiance + shade_by_lamp(surface, ray, *options.lamp)) : radiance;
  };

  const DealtPoints object_points(options.lobe_samples, options.object_samples);
  const DealtPoints edge_points(options.lobe_samples, options.edge_samples);
  RenderedView view{ImageF(width, height, 3), ImageU8(width, height, 1)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<Surface> above(width + 1), below(width + 1);
    const auto trace_corners = [&](int y, std::vector<Surface>& corners) {
      for (int x = 0; x <= width; ++x) corners[x] = first_surface(eye, ray_at(x - 0.5f, y - 0.5f));
    };
    trace_corners(rows.begin(), below);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      std::swap(above, below);
      trace_corners(y + 1, below);
      for (int x = 0; x < width; ++x) {
        const Vector3f central = ray_at(x, y);
        const Surface middle = first_surface(eye, central);
        view.mask.at(x, y) = middle.object ? 255 : 0;
        const bool uniform = middle.same_kind(above[x]) && middle.same_kind(above[x + 1]) &&
                             middle.same_kind(below[x]) && middle.same_kind(below[x + 1]);
        Eigen::Map<Array3f> pixel(view.radiance.pixel(x, y));
        if (uniform && !middle.object) {
          pixel = lit(middle, central, {});
          continue;
        }
        const int count = uniform ? options.object_samples : options.edge_samples;
        Array3f sum = Array3f::Zero();
        for (int k = 0; k < count; ++k) {
          const Eigen::Vector2f at = spread_point(k, count);
          const Vector3f ray = ray_at(x - 0.5f + at.x(), y - 0.5f + at.y());
          sum += lit(first_surface(eye, ray), ray, (uniform ? object_points : edge_points).share(k));
        }
        pixel = sum / count;
      }
    }
  });
  return view;
}

}  // namespace sheen
