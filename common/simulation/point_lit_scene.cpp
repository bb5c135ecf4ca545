// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/point_lit_scene.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <stdexcept>

namespace sheen {

PointLitScene::PointLitScene(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, Reflect reflect,
                             PosedCamera camera)
    : rays_(std::make_shared<const RayScene>(mesh)),
      reflect_(std::move(reflect)),
      camera_(std::move(camera)),
      lift_(static_cast<float>(1e-4 * bounding_sphere(mesh).radius)),
      surfaces_(static_cast<std::size_t>(camera_.camera.width) * static_cast<std::size_t>(camera_.camera.height)) {
  const Rigid3 object_from_camera = camera_.camera_from_object.inverse();
  const Eigen::Vector3f eye = object_from_camera.translation.cast<float>();
  tbb::parallel_for(0, camera_.camera.height, [&](int y) {
    for (int x = 0; x < camera_.camera.width; ++x) {
      const auto along = camera_.camera.ray({double(x), double(y)});
      if (!along) continue;
      const Ray ray{eye, (object_from_camera.rotation * *along).cast<float>()};
      const Hit hit = rays_->intersect(ray);
      if (!hit || !hit.front) continue;
      const Triangle& corners = mesh.triangles[hit.triangle];
      Surface& surface = surfaces_[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.camera.width) +
                                   static_cast<std::size_t>(x)];
      surface = {.seen = true,
                 .place = eye + hit.distance * ray.direction,
                 .normal = ((1 - hit.u - hit.v) * normals[corners[0]] + hit.u * normals[corners[1]] +
                            hit.v * normals[corners[2]])
                               .normalized(),
                 .flat_normal = mesh.area_normal(hit.triangle).normalized(),
                 .eye = -ray.direction.normalized()};
    }
  });
}

PointLitScene::Arrival PointLitScene::arrival(const Surface& surface, const LightState& light) const {
  if (light.kind != LightKind::kDirectional && light.kind != LightKind::kPoint)
    throw std::invalid_argument("a light must be a point or directional");
  const bool far = light.kind == LightKind::kDirectional;
  const Eigen::Vector3f way =
      far ? light.position.normalized().cast<float>() : Eigen::Vector3f(light.position.cast<float>() - surface.place);
  const float distance = way.norm();
  Arrival arrival{.direction = way / distance};
  arrival.cosine = surface.normal.dot(arrival.direction);
  if (!surface.seen || arrival.cosine <= 0 || surface.flat_normal.dot(arrival.direction) <= 0) return arrival;
  const Ray shadow{surface.place + lift_ * surface.flat_normal, way, 0, far ? 1e30f : 1.0f};
  if (!rays_->occluded(shadow)) arrival.strength = far ? 1 : 1 / (distance * distance);
  return arrival;
}

ImageF PointLitScene::picture(const LightState& light) const {
  ImageF picture(camera_.camera.width, camera_.camera.height, 3);
  tbb::parallel_for(std::size_t{0}, surfaces_.size(), [&](std::size_t i) {
    const Surface& surface = surfaces_[i];
    const Arrival from = arrival(surface, light);
    if (from.strength == 0) return;
    const Eigen::Array3f radiance = reflect_(surface.place, surface.normal, from.direction, surface.eye) *
                                    (from.cosine * from.strength) * light.rgb.array();
    Eigen::Map<Eigen::Array3f>(picture.data() + 3 * i) = radiance;
  });
  return picture;
}

ImageU8 PointLitScene::lit(const LightState& light) const {
  ImageU8 lit(camera_.camera.width, camera_.camera.height, 1);
  tbb::parallel_for(std::size_t{0}, surfaces_.size(),
                    [&](std::size_t i) { lit.data()[i] = arrival(surfaces_[i], light).strength > 0 ? 255 : 0; });
  return lit;
}

ImageU8 PointLitScene::mask() const {
  ImageU8 mask(camera_.camera.width, camera_.camera.height, 1);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) mask.data()[i] = surfaces_[i].seen ? 255 : 0;
  return mask;
}

}  // namespace sheen
