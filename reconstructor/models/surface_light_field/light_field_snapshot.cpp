// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

#include <algorithm>
#include <cmath>

#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/next_view.h"

namespace sheen {
namespace {

/// Shades from the surface maps and a vector of view coefficients per corner. It lives no longer than what shares the
/// snapshot: it refers to its patches.
class LightFieldShader : public ViewShader {
 public:
  LightFieldShader(const LightFieldSnapshot& snapshot, Eigen::MatrixXf coefficients, float exposure,
                   std::vector<SurfaceQuality> quality)
      : mesh_(snapshot.shared_mesh()),
        maps_(snapshot.shared_maps()),
        coefficients_(std::move(coefficients)),
        exposure_(exposure),
        brightest_(snapshot.brightest()),
        quality_(std::move(quality)) {
    patches_.reserve(snapshot.patch_count());
    for (std::size_t i = 0; i < snapshot.patch_count(); ++i) patches_.push_back(snapshot.patch(i));
    places_.reserve(mesh_->triangles.size());
    for (std::size_t t = 0; t < mesh_->triangles.size(); ++t) places_.push_back(snapshot.place(t));
  }

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const TrianglePlace& place = places_[triangle];
    const SurfacePatch* patch = patches_[place.patch].get();
    if (!patch || patch->rank() == 0) return {};
    const LatticeStencil stencil = lattice_stencil(maps_->resolution(triangle), u, v);
    const auto first = static_cast<int>(place.first_sample);
    const Eigen::Vector3f encoded = patch->colour(place, stencil, coefficients_, u, v).cwiseMin(brightest_);
    SampleState state = SampleState::kUnseen;
    for (int k = 0; k < 3; ++k)
      if (stencil.weight[k] > 0.25f) state = std::max(state, patch->state(first + stencil.index[k]));
    const Eigen::Vector3f radiance(srgb_decode(encoded.x()), srgb_decode(encoded.y()), srgb_decode(encoded.z()));
    return {exposure_ * radiance, state};
  }
  SurfaceQuality quality(std::uint32_t triangle) const override { return quality_[triangle]; }

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const MapLayout> maps_;
  std::vector<std::shared_ptr<const SurfacePatch>> patches_;
  std::vector<TrianglePlace> places_;  ///< per triangle
  Eigen::MatrixXf coefficients_;
  float exposure_, brightest_;
  std::vector<SurfaceQuality> quality_;
};

/// Of what the cameras chose.
float mean_exposure(const LightFieldSnapshot& snapshot) {
  float sum = 0;
  for (const PosedCamera& from : snapshot.cameras())
    sum += snapshot.exposure().at(camera_centre(from.camera_from_object));
  return snapshot.cameras().empty() ? 1 : sum / static_cast<float>(snapshot.cameras().size());
}

}  // namespace

std::unique_ptr<ViewShader> LightFieldSnapshot::shader_for(const ViewQuery& query) const {
  return std::make_unique<LightFieldShader>(*this, coefficients_for(query.eye), exposure().at(query.eye),
                                            quality_for(query.eye));
}

std::optional<AverageLook> LightFieldSnapshot::average_look() const {
  if (empty()) return std::nullopt;
  return AverageLook{std::make_unique<LightFieldShader>(*this, average_coefficients(), mean_exposure(*this),
                                                        std::vector<SurfaceQuality>(mesh_->triangles.size())),
                     maps_->total_samples()};
}

ViewAdvice LightFieldSnapshot::advise_next_view(const Eigen::Vector3d& eye) const {
  return sheen::advise_next_view(*this, eye);
}

std::vector<SurfaceDemand> LightFieldSnapshot::demand() const {
  std::vector<std::size_t> sharers(patch_count());
  for (std::size_t t = 0; t < mesh_->triangles.size(); ++t) ++sharers[place(t).patch];
  std::vector<SurfaceDemand> demand(mesh_->triangles.size());
  for (std::size_t t = 0; t < demand.size(); ++t) {
    const std::size_t index = place(t).patch;
    const std::shared_ptr<const SurfacePatch> in = patch(index);
    if (!in || in->rank() == 0) continue;
    demand[t] = {static_cast<float>(in->rank()), static_cast<float>(maps_->resolution(t)),
                 static_cast<float>(patch_bytes(index)) / static_cast<float>(sharers[index])};
  }
  return demand;
}

std::vector<SurfaceQuality> LightFieldSnapshot::quality_for(const Eigen::Vector3d& eye) const {
  std::call_once(guidance_made_, [this] { guidance_ = make_guidance(*this); });
  return guidance_->of_triangles(eye);
}

}  // namespace sheen
