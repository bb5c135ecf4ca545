// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/seen_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <array>
#include <numeric>
#include <span>

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr float kClearance = 5e-5f;  // of the mesh's radius
constexpr int kEdgeSide = 4;         // rays along a side of a pixel

}  // namespace

Occluders::Occluders(const Mesh& mesh) : mesh_(mesh), rays_(mesh) {
  const auto radius = static_cast<float>(bounding_sphere(mesh).radius);
  clearance_ = kClearance * radius;
  far_ = 4 * radius;
}

Occluders::Place Occluders::place_or_none(const Ray& ray, const Hit& hit) const {
  if (!hit) return {Vector3f::Zero(), Vector3f::Zero(), hit};
  const Vector3f normal = mesh_.area_normal(hit.triangle).normalized();
  return {ray.origin + hit.distance * ray.direction, normal.dot(ray.direction) > 0 ? Vector3f(-normal) : normal, hit};
}

std::optional<Ray> Occluders::shadow_ray(const Place& place, const Lamp& lamp) const {
  const Vector3f towards = lamp.towards(place.point);
  if (place.facing.dot(towards) <= 0) return std::nullopt;
  return Ray{place.point + clearance_ * place.facing, towards, 0, lamp.kind == LightKind::kPoint ? 1 : far_};
}

bool Occluders::reached(const Place& place, const Lamp& lamp) const {
  const std::optional<Ray> ray = shadow_ray(place, lamp);
  return ray && !rays_.occluded(*ray);
}

void Occluders::reached(std::span<const Place> places, const Lamp& lamp, std::span<std::uint8_t> answers) const {
  std::vector<Ray> rays;
  std::vector<std::size_t> asked;
  rays.reserve(places.size());
  asked.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    answers[i] = 0;
    const std::optional<Ray> ray = shadow_ray(places[i], lamp);
    if (!ray) continue;
    rays.push_back(*ray);
    asked.push_back(i);
  }
  std::vector<std::uint8_t> blocked(rays.size());
  rays_.occluded(rays, blocked);
  for (std::size_t k = 0; k < asked.size(); ++k) answers[asked[k]] = !blocked[k];
}

SeenSurface::SeenSurface(const Occluders& occluders, const PosedCamera& from)
    : occluders_(&occluders), from_(from), object_from_camera_(from.camera_from_object.inverse()) {
  const int w = from.camera.width, h = from.camera.height;
  centres_.resize(std::size_t(w) * h);
  corners_.resize(std::size_t(w + 1) * (h + 1));
  // A row's rays are alike: many at once.
  const auto look = [&](double first_x, double y, std::span<Occluders::Place> row) {
    std::vector<Ray> rays(row.size());
    std::vector<Hit> hits(row.size());
    for (std::size_t x = 0; x < row.size(); ++x) rays[x] = ray_at(first_x + static_cast<double>(x), y);
    occluders.rays().intersect(rays, hits);
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = occluders.place_or_none(rays[x], hits[x]);
  };
  tbb::parallel_for(0, h + 1, [&](int y) {
    look(-0.5, y - 0.5, {corners_.data() + std::size_t(y) * (w + 1), std::size_t(w + 1)});
    if (y < h) look(0, y, {centres_.data() + std::size_t(y) * w, std::size_t(w)});
  });
}

Ray SeenSurface::ray_at(double x, double y) const {
  const auto ray = from_.camera.ray({x, y});
  const Vector3f eye = object_from_camera_.translation.cast<float>();
  // A pixel that the lens cannot reach looks nowhere: an empty interval hits nothing.
  return ray ? Ray{eye, (object_from_camera_.rotation * *ray).cast<float>()} : Ray{eye, {0, 0, 1}, 0, -1};
}

ImageF SeenSurface::depth() const {
  ImageF depth(from_.camera.width, from_.camera.height, 1);
  for (std::size_t i = 0; i < centres_.size(); ++i)
    if (!centres_[i].facing.isZero())
      depth.data()[i] = static_cast<float>((from_.camera_from_object * centres_[i].point.cast<double>()).z());
  return depth;
}

ImageF SeenSurface::normals() const {
  ImageF normals(from_.camera.width, from_.camera.height, 3);
  for (std::size_t i = 0; i < centres_.size(); ++i) Vector3f::Map(normals.data() + 3 * i) = centres_[i].facing;
  return normals;
}

ImageU8 SeenSurface::reached(const Lamp& lamp) const {
  const int w = from_.camera.width, h = from_.camera.height;
  const std::size_t row = std::size_t(w) + 1;
  std::vector<std::uint8_t> at_corner(corners_.size());
  tbb::parallel_for(std::size_t{0}, std::size_t(h) + 1, [&](std::size_t y) {
    occluders_->reached({corners_.data() + y * row, row}, lamp, {at_corner.data() + y * row, row});
  });
  ImageU8 out(w, h, 1);
  tbb::parallel_for(0, h, [&](int y) {
    for (int x = 0; x < w; ++x) {
      const std::uint8_t* corner = at_corner.data() + std::size_t(y) * row + x;
      const int lit = corner[0] + corner[1] + corner[row] + corner[row + 1];
      out.at(x, y) = lit == 0 ? 0 : lit == 4 ? 255 : reached_within(x, y, lamp);
    }
  });
  return out;
}

/// By rays through the pixel, of which few differ.
std::uint8_t SeenSurface::reached_within(int x, int y, const Lamp& lamp) const {
  constexpr int kRays = kEdgeSide * kEdgeSide;
  std::array<Ray, kRays> rays;
  std::array<Hit, kRays> hits;
  for (int k = 0; k < kRays; ++k)
    rays[k] = ray_at(x - 0.5 + (k % kEdgeSide + 0.5) / kEdgeSide, y - 0.5 + (k / kEdgeSide + 0.5) / kEdgeSide);
  occluders_->rays().intersect(rays, hits);
  std::array<Occluders::Place, kRays> places;
  for (int k = 0; k < kRays; ++k) places[k] = occluders_->place_or_none(rays[k], hits[k]);
  std::array<std::uint8_t, kRays> lit;
  occluders_->reached(places, lamp, lit);
  return static_cast<std::uint8_t>(std::accumulate(lit.begin(), lit.end(), 0) * 255 / kRays);
}

}  // namespace sheen
