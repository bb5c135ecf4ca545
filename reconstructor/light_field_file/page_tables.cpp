// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/page_tables.h"

#include <algorithm>

#include "reconstructor/light_field_file/triangle_edges.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {
namespace {

constexpr float kMostInByte = 255, kMostSigned = 127;

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0f, kMostInByte) + 0.5f);
}

template <typename Vector, typename Numbers>
void append(const Vector& vector, Numbers& numbers) {
  for (Eigen::Index i = 0; i < vector.size(); ++i)
    numbers.push_back(static_cast<typename Numbers::value_type>(vector[i]));
}

}  // namespace

std::vector<double> scene_table(const Mesh& mesh, const std::vector<PosedCamera>& cameras, float brightest) {
  const BoundingSphere sphere = bounding_sphere(mesh);
  const auto view = opening_view(cameras, sphere.centre).value_or(OpeningView{{0, 0, 1}, {0.6, -0.7, 0.4}});
  std::vector<double> scene;
  append(sphere.centre, scene);
  scene.push_back(sphere.radius);
  append(view.up, scene);
  append(view.direction.normalized(), scene);
  append(mesh.origin, scene);
  scene.push_back(brightest);
  return scene;
}

std::vector<float> camera_table(const std::vector<PosedCamera>& cameras) {
  std::vector<float> numbers;
  for (const PosedCamera& from : cameras) {
    append(camera_centre(from.camera_from_object), numbers);
    const Eigen::Matrix3d axes = from.camera_from_object.rotation.toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) append(axes.row(axis), numbers);
    numbers.push_back(static_cast<float>(0.5 * from.camera.width / from.camera.fx));
    numbers.push_back(static_cast<float>(0.5 * from.camera.height / from.camera.fy));
  }
  return numbers;
}

std::vector<std::uint32_t> edge_table(const Mesh& mesh) {
  const std::vector<TriangleEdge> all = triangle_edges(mesh);
  std::vector<std::uint32_t> numbers;
  for (std::size_t first = 0, end = 0; first < all.size(); first = end) {
    while (end < all.size() && all[end].same_place(all[first])) ++end;
    const std::uint32_t other = end - first == 2 ? all[first + 1].triangle : all[first].triangle;
    numbers.insert(numbers.end(), {all[first].low, all[first].high, all[first].triangle, other});
  }
  return numbers;
}

MeanRange pack_means(const Eigen::VectorXf& colours, std::span<const SampleState> states, std::uint8_t* texels) {
  constexpr float kLeastWidth = 1e-6f;
  MeanRange range;
  const bool known = colours.size() > 0;
  if (known) range = {colours.minCoeff(), std::max(colours.maxCoeff() - colours.minCoeff(), kLeastWidth)};
  const float step = kMostInByte / range.width;
  Eigen::Index value = 0;
  for (const SampleState state : states) {
    for (int c = 0; known && c < 3; ++c) texels[c] = byte_of(step * (colours[value++] - range.low));
    texels[3] = static_cast<std::uint8_t>(127 * static_cast<int>(state));
    texels += kPageTexelBytes;
  }
  return range;
}

float pack_term(const Eigen::Ref<const Eigen::VectorXf>& colours, std::size_t stride, std::uint8_t* texels) {
  constexpr float kLeast = 1e-12f;
  const float largest = std::max(colours.cwiseAbs().maxCoeff(), kLeast);
  const float step = kMostSigned / largest;
  for (Eigen::Index value = 0; value < colours.size(); value += 3, texels += kPageTexelBytes * stride)
    for (int c = 0; c < 3; ++c) texels[c] = byte_of(128 + step * colours[value + c]);
  return largest;
}

}  // namespace sheen
