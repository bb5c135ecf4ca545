// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_bake.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector3f;

// Rays start this far off a surface along its smooth normal, above the facets that stand in for it.
constexpr float kRayOffset = 3e-4f;
constexpr float kPi = float(M_PI);

/// Spherical Fibonacci points: about the same solid angle each.
std::vector<Vector3f> even_directions(int count) {
  const double golden = M_PI * (3 - std::sqrt(5.0));
  std::vector<Vector3f> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), phi = golden * i;
    directions.emplace_back(float(r * std::cos(phi)), float(r * std::sin(phi)), float(z));
  }
  return directions;
}

/// Reflectance of a surface whose lobe counts as diffuse.
Array3f total_albedo(const Material& material) {
  const Array3f lobe = mean_lobe_albedo(material);
  return material.albedo * (1 - lobe) + lobe;
}

Array3f pixel(const ImageF& image, int x, int y) {
  return Eigen::Map<const Array3f>(image.pixel(x, y));
}

void set_pixel(ImageF& image, int x, int y, const Array3f& value) {
  Eigen::Map<Array3f>(image.pixel(x, y)) = value;
}

}  // namespace

LightBake::LightBake(const SimulatedScene& scene, const RayScene& rays, const BakeOptions& options)
    : scene_(scene),
      rays_(rays),
      bounds_(bounding_sphere(scene.object.mesh)),
      stage_cell_(options.stage_cell_m),
      stage_half_(scene.stage ? scene.stage->table_radius() + options.stage_cell_m : 0),
      sky_directions_(even_directions(options.sky_directions)),
      bounce_directions_(even_directions(options.bounce_directions)) {
  for (const Vector3f& d : sky_directions_) sky_radiance_.push_back(scene.lighting.environment(d));

  const TestObject& object = scene.object;
  const std::size_t vertices = object.mesh.vertices.size();
  std::vector<Point> points;
  for (std::size_t i = 0; i < vertices; ++i) {
    points.push_back({object.mesh.vertices[i] + kRayOffset * object.normals[i], object.normals[i]});
    object_albedo_.push_back(total_albedo(object.material(object.mesh.vertices[i])));
  }
  object_irradiance_.assign(vertices, Array3f::Zero());
  object_radiance_.assign(vertices, Array3f::Zero());

  const int side = scene.stage ? static_cast<int>(std::ceil(2 * stage_half_ / stage_cell_)) + 1 : 0;
  stage_albedo_ = stage_irradiance_ = stage_radiance_ = ImageF(side, side, 3);
  tbb::parallel_for(0, side, [&](int row) {
    constexpr int kSub = 5;  // the print is averaged over three cells, so that reflections of it do not alias
    for (int column = 0; column < side; ++column) {
      const Point p = stage_point(column, row);
      Array3f sum = Array3f::Zero();
      for (int i = 0; i < kSub * kSub; ++i) {
        const float x = p.position.x() + ((i % kSub + 0.5f) / kSub - 0.5f) * 3 * stage_cell_;
        const float y = p.position.y() + ((i / kSub + 0.5f) / kSub - 0.5f) * 3 * stage_cell_;
        sum += scene.stage->albedo(scene.stage->region(x, y), x, y);
      }
      set_pixel(stage_albedo_, column, row, sum / (kSub * kSub));
    }
  });

  // Light first, then what the surfaces pass on to one another.
  std::vector<Array3f> object_direct(vertices);
  ImageF stage_direct(side, side, 3);
  const auto for_all = [&](const auto& gather, const auto& store_object, const auto& store_stage) {
    tbb::parallel_for(std::size_t(0), vertices, [&](std::size_t i) { store_object(i, gather(points[i])); });
    tbb::parallel_for(0, side, [&](int row) {
      for (int column = 0; column < side; ++column) store_stage(column, row, gather(stage_point(column, row)));
    });
  };
  for_all([&](const Point& p) { return gather_lights(p, options); },
          [&](std::size_t i, const Array3f& e) { object_irradiance_[i] = object_direct[i] = e; },
          [&](int x, int y, const Array3f& e) { set_pixel(stage_direct, x, y, e); });
  stage_irradiance_ = stage_direct;
  update_outgoing();
  for (int bounce = 0; bounce < options.bounces; ++bounce) {
    for_all([&](const Point& p) { return gather_reflections(p); },
            [&](std::size_t i, const Array3f& e) { object_irradiance_[i] = object_direct[i] + e; },
            [&](int x, int y, const Array3f& e) { set_pixel(stage_irradiance_, x, y, pixel(stage_direct, x, y) + e); });
    update_outgoing();
  }
}

LightBake::Point LightBake::stage_point(int column, int row) const {
  return {{column * stage_cell_ - stage_half_, row * stage_cell_ - stage_half_, kRayOffset / 3}, Vector3f::UnitZ()};
}

void LightBake::update_outgoing() {
  for (std::size_t i = 0; i < object_irradiance_.size(); ++i)
    object_radiance_[i] = object_albedo_[i] * object_irradiance_[i] / kPi;
  for (std::size_t i = 0; i < stage_radiance_.size(); ++i)
    stage_radiance_.data()[i] = stage_albedo_.data()[i] * stage_irradiance_.data()[i] / kPi;
}

bool LightBake::misses_object(const Vector3f& origin, const Vector3f& direction) const {
  const Vector3f to_centre = bounds_.centre.cast<float>() - origin;
  const float squared = to_centre.squaredNorm(), radius2 = float(bounds_.radius * bounds_.radius);
  if (squared <= radius2) return false;
  const float along = to_centre.dot(direction);
  return along <= 0 || squared - along * along > radius2;
}

LightBake::Meeting LightBake::meet(const Vector3f& origin, const Vector3f& direction) const {
  Meeting meeting;
  if (!misses_object(origin, direction)) meeting.object = rays_.intersect({origin, direction});
  if (!meeting.object) meeting.stage = meet_stage(origin, direction);
  return meeting;
}

std::optional<Eigen::Vector2f> LightBake::meet_stage(const Vector3f& origin, const Vector3f& direction) const {
  if (!scene_.stage || direction.z() >= 0 || origin.z() <= 0) return std::nullopt;
  const Eigen::Vector2f at = origin.head<2>() - origin.z() / direction.z() * direction.head<2>();
  return at.norm() < scene_.stage->table_radius() ? std::optional(at) : std::nullopt;
}

Array3f LightBake::reflected(const Meeting& meeting) const {
  if (meeting.object) return meeting.object.front ? object_radiance(meeting.object) : Array3f::Zero().eval();
  if (meeting.stage) return stage_radiance(meeting.stage->x(), meeting.stage->y());
  return Array3f::Zero();
}

void LightBake::incoming(std::span<const Ray> rays, std::span<Array3f> radiance) const {
  std::array<Hit, LobePoints::kCount> hits;
  rays_.intersect(rays, std::span(hits).first(rays.size()));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto& [origin, direction, near, far] = rays[i];
    const Meeting meeting{hits[i], hits[i] ? std::nullopt : meet_stage(origin, direction)};
    if (meeting.object || meeting.stage) {
      radiance[i] = reflected(meeting);
      continue;
    }
    radiance[i] = scene_.lighting.environment(direction);
    if (const auto& light = scene_.lighting.area_light)
      if (const auto crossing = light->meet(origin, direction))
        radiance[i] +=
            (light->radiance - radiance[i]) * crossing->emission;  // where it does not shine, it is not there
  }
}

Array3f LightBake::gather_lights(const Point& point, const BakeOptions& options) const {
  // The sum of cosines of the very directions used makes uniform light come out exactly.
  Array3f sky = Array3f::Zero();
  float cosines = 0;
  for (std::size_t i = 0; i < sky_directions_.size(); ++i) {
    const float cosine = sky_directions_[i].dot(point.normal);
    if (cosine <= 0) continue;
    cosines += cosine;
    const Meeting meeting = meet(point.position, sky_directions_[i]);
    if (!meeting.object && !meeting.stage) sky += cosine * sky_radiance_[i];
  }
  Array3f irradiance = sky * (kPi / cosines);
  if (const auto& light = scene_.lighting.area_light) {
    const int n = options.area_light_samples;
    const Vector3f shine = light->normal();
    Array3f sum = Array3f::Zero();
    for (int k = 0; k < n * n; ++k) {
      const float a = (2 * (k % n) + 1.0f) / n - 1, b = (2 * (k / n) + 1.0f) / n - 1;
      const Vector3f to_light = light->centre + a * light->half_u + b * light->half_v - point.position;
      const float distance2 = to_light.squaredNorm();
      const Vector3f direction = to_light / std::sqrt(distance2);
      const float cosine = direction.dot(point.normal), light_cosine = -direction.dot(shine);
      if (cosine <= 0 || light_cosine <= 0) continue;
      const float form = cosine * light_cosine / distance2 * light->profile(a, b);
      if (form <= 0) continue;
      const Meeting meeting = meet(point.position, direction);
      if (meeting.object || meeting.stage) continue;
      // The emitter hides what shines behind it.
      sum += form * (light->radiance - scene_.lighting.environment(direction));
    }
    irradiance += sum * (light->area() / (n * n));
  }
  return irradiance;
}

Array3f LightBake::gather_reflections(const Point& point) const {
  Array3f sum = Array3f::Zero();
  float cosines = 0;
  for (const Vector3f& direction : bounce_directions_) {
    const float cosine = direction.dot(point.normal);
    if (cosine <= 0) continue;
    cosines += cosine;
    sum += cosine * reflected(meet(point.position, direction));
  }
  return sum * (kPi / cosines);
}

Array3f LightBake::interpolate(const std::vector<Array3f>& values, const Hit& hit) const {
  const Triangle& t = scene_.object.mesh.triangles[hit.triangle];
  return values[t[0]] * (1 - hit.u - hit.v) + values[t[1]] * hit.u + values[t[2]] * hit.v;
}

Array3f LightBake::interpolate(const ImageF& grid, float x, float y) const {
  const float last = static_cast<float>(grid.width() - 1);
  const float gx = std::clamp((x + stage_half_) / stage_cell_, 0.0f, last);
  const float gy = std::clamp((y + stage_half_) / stage_cell_, 0.0f, last);
  const int x0 = std::min(static_cast<int>(gx), grid.width() - 2),
            y0 = std::min(static_cast<int>(gy), grid.height() - 2);
  const float fx = gx - x0, fy = gy - y0;
  return (pixel(grid, x0, y0) * (1 - fx) + pixel(grid, x0 + 1, y0) * fx) * (1 - fy) +
         (pixel(grid, x0, y0 + 1) * (1 - fx) + pixel(grid, x0 + 1, y0 + 1) * fx) * fy;
}

}  // namespace sheen
