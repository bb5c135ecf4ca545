// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/mean_look.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "reconstructor/lumigraph_file/four_pixels.h"
#include "reconstructor/surface/nearest_seen.h"

namespace sheen {

using Eigen::Vector3f;

void MeanLook::Matt::add(const IntrinsicView& view, std::size_t pixel, float part) {
  const auto three = [pixel](const ImageHalf& image) {
    return Eigen::Map<const Eigen::Matrix<Eigen::half, 3, 1>>(image.data() + 3 * pixel).cast<float>().eval();
  };
  const Vector3f reflectance = three(view.reflectance);
  ambient += part * static_cast<float>(view.ambient.data()[pixel]) * reflectance;
  slope += part * reflectance * three(view.slope).transpose();
  weight += part;
}

MeanLook::Matt& MeanLook::Matt::operator+=(const Matt& other) {
  ambient += other.ambient;
  slope += other.slope;
  weight += other.weight;
  return *this;
}

MeanLook::Matt MeanLook::Matt::mean() const {
  return weight > 0 ? Matt{ambient / weight, slope / weight, 1} : Matt{};
}

/// The more frontal a view, the more it counts.
MeanLook::Matt MeanLook::seen_of(const Vector3f& point, const Vector3f& normal, const LumigraphData& data) {
  constexpr float kGrazing = 0.1f;  // cosine
  Matt sum;
  for (const auto& view : data.views) {
    const Rigid3& pose = view->from.camera_from_object;
    const float cosine = normal.dot((camera_centre(pose).cast<float>() - point).normalized());
    if (cosine < kGrazing) continue;
    const Eigen::Vector3d in_camera = pose * point.cast<double>();
    const auto pixel = view->from.camera.project(in_camera);
    if (!pixel || !view->from.camera.contains(*pixel, -0.5)) continue;
    const FourPixels near(view->depth, *pixel, in_camera.z());
    near.for_each_that_shows([&](std::size_t at, float weight) { sum.add(*view, at, cosine * cosine * weight); });
  }
  return sum.mean();
}

MeanLook::Matt MeanLook::mean_of(const LumigraphData& data) {
  Matt sum;
  for (const auto& view : data.views)
    for (std::size_t pixel = 0; pixel < view->depth.size(); ++pixel)
      if (view->depth.data()[pixel] > 0) sum.add(*view, pixel, 1);
  return sum.mean();
}

MeanLook::MeanLook(std::shared_ptr<const Mesh> mesh, const LumigraphData& data)
    : mesh_(std::move(mesh)), looks_(mesh_->vertices.size()) {
  const std::vector<Vector3f> normals = vertex_normals(*mesh_);
  std::vector<std::uint8_t> seen(looks_.size());
  tbb::parallel_for(std::size_t{0}, looks_.size(), [&](std::size_t v) {
    looks_[v] = seen_of(mesh_->vertices[v], normals[v], data);
    seen[v] = looks_[v].weight > 0;
  });
  // Of large triangles the middle may be seen where no corner is.
  std::vector<Matt> round(looks_.size());
  for (std::size_t t = 0; t < mesh_->triangles.size(); ++t) {
    const Triangle& corners = mesh_->triangles[t];
    if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return seen[v] != 0; })) continue;
    const Vector3f middle = (mesh_->corner(t, 0) + mesh_->corner(t, 1) + mesh_->corner(t, 2)) / 3;
    const Matt look = seen_of(middle, mesh_->area_normal(t).normalized(), data);
    if (look.weight > 0)
      for (const std::uint32_t v : corners) round[v] += look;
  }
  for (std::size_t v = 0; v < looks_.size(); ++v) {
    if (!(round[v].weight > 0)) continue;
    looks_[v] = round[v].mean();
    seen[v] = 1;
  }
  const std::vector<std::uint32_t> source = nearest_seen(*mesh_, seen);
  const Matt anywhere = mean_of(data);
  for (std::size_t v = 0; v < looks_.size(); ++v)
    if (!seen[v]) looks_[v] = source[v] == kNoVertex ? anywhere : looks_[source[v]];
  seen_ = std::make_shared<const std::vector<std::uint8_t>>(std::move(seen));
}

MeanLook::Lit MeanLook::lit(std::vector<LitAndDark> colours) const {
  Lit lit;
  lit.mesh_ = mesh_;
  lit.seen_ = seen_;
  lit.colours_ = std::move(colours);
  return lit;
}

MeanLook::Lit MeanLook::in(const Lamp& lamp, const Vector3f& rgb) const {
  std::vector<LitAndDark> colours;
  for (std::size_t v = 0; v < looks_.size(); ++v) {
    const Vector3f dark = looks_[v].ambient.cwiseProduct(rgb);
    const Vector3f more = looks_[v].added_by(lamp.incidence(mesh_->vertices[v])).cwiseProduct(rgb);
    colours.push_back({dark + more, dark});
  }
  return lit(std::move(colours));
}

MeanLook::Lit MeanLook::in_all(const LightSet& lights) const {
  std::vector<LitAndDark> colours(looks_.size());
  for (std::size_t v = 0; v < looks_.size(); ++v) {
    Vector3f more = Vector3f::Zero();
    for (int light = 0; light < lights.size(); ++light)
      more += looks_[v].added_by(lights.lamp(light).incidence(mesh_->vertices[v]));
    colours[v].lit = colours[v].dark = looks_[v].ambient + more / std::max<float>(1, static_cast<float>(lights.size()));
  }
  return lit(std::move(colours));
}

MeanLook::Lit::Sample MeanLook::Lit::at(std::uint32_t triangle, float u, float v) const {
  const std::array<float, 3> weights{1 - u - v, u, v};
  Sample sample;
  float seen = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint32_t vertex = mesh_->triangles[triangle][c];
    sample.lit += weights[c] * colours_[vertex].lit;
    sample.dark += weights[c] * colours_[vertex].dark;
    if ((*seen_)[vertex] != 0) seen += weights[c];
  }
  if (seen >= 0.5f) sample.state = SampleState::kImputed;
  return sample;
}

}  // namespace sheen
