// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/lit_object.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "common/simulation/sensor.h"

namespace sheen {

LitObject::LitObject(const TestObject& object)
    : mesh_(object.mesh), normals_(object.normals), material_(object.material), painter_(mesh_) {}

LitObject::LitObject(const TestObject& object, const Mesh& mesh)
    : mesh_(mesh), normals_(vertex_normals(mesh)), material_(object.material), painter_(mesh_) {}

ImageF LitObject::draw(const Camera& camera, const Rigid3& camera_from_object) const {
  const Eigen::Vector3f light = Eigen::Vector3f(0.4f, -0.3f, 0.87f).normalized();
  const Eigen::Vector3f eye = camera_centre(camera_from_object).cast<float>();
  const std::vector<Hit> hits = painter_.cast(camera, camera_from_object);
  ImageF image(camera.width, camera.height, 3, 0.1f);
  tbb::parallel_for(std::size_t{0}, hits.size(), [&](std::size_t i) {
    if (!hits[i] || !hits[i].front) return;
    const auto& [a, b, c] = mesh_.triangles[hits[i].triangle];
    const float u = hits[i].u, v = hits[i].v;
    const Eigen::Vector3f place = (1 - u - v) * mesh_.vertices[a] + u * mesh_.vertices[b] + v * mesh_.vertices[c];
    const Eigen::Vector3f normal = ((1 - u - v) * normals_[a] + u * normals_[b] + v * normals_[c]).normalized();
    const Eigen::Vector3f half = (light + (eye - place).normalized()).normalized();
    const Eigen::Vector3f diffuse = material_(place).albedo;
    const float lit = 0.25f + 0.6f * std::max(0.0f, normal.dot(light));
    const float gloss = 0.4f * std::pow(std::max(0.0f, normal.dot(half)), 60.0f);
    Eigen::Map<Eigen::Vector3f>(image.data() + 3 * i) = lit * diffuse + Eigen::Vector3f::Constant(gloss);
  });
  return through_lens(image, kLensSpotPx);
}

Capture LitObject::photograph(const Camera& camera, const Rigid3& camera_from_object, std::uint64_t number) const {
  ImageF mosaic = mosaic_rggb(draw(camera, camera_from_object));
  add_sensor_noise(mosaic, {}, number);
  Capture capture;
  capture.sequence = number;
  capture.camera = camera;
  capture.image = quantize_rggb(mosaic);
  capture.exposure.locked = true;
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = camera_from_object;
  return capture;
}

}  // namespace sheen
