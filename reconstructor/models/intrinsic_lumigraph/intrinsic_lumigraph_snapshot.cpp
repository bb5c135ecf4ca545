// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/parallel/for_each.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_pictures.h"
#include "reconstructor/models/intrinsic_lumigraph/lamp_reach.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"
#include "reconstructor/models/intrinsic_lumigraph/surface_blend.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr float kGuess = 0.14f;  // RMS of encoded values of what is not known

SurfaceQuality quality_of(const LumigraphData& data) {
  return {true, static_cast<float>(data.error), 1, 1};
}

Vector3f point_of(const Mesh& mesh, std::uint32_t triangle, float u, float v) {
  return (1 - u - v) * mesh.corner(triangle, 0) + u * mesh.corner(triangle, 1) + v * mesh.corner(triangle, 2);
}

/// On a mesh. Where it is not told what a lamp reaches, the colours are what they are.
class MeshShader : public ViewShader {
 public:
  MeshShader(const IntrinsicLumigraphSnapshot& model, SurfaceBlend blend, std::optional<LampReach> reach)
      : model_(model), blend_(std::move(blend)), reach_(std::move(reach)) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override { return sample(triangle, u, v, true); }
  SurfaceSample shade_back(std::uint32_t triangle, float u, float v) const override {
    return sample(triangle, u, v, false);
  }
  SurfaceQuality quality(std::uint32_t) const override { return quality_of(*model_.data()); }

 private:
  SurfaceSample sample(std::uint32_t triangle, float u, float v, bool front) const {
    const SurfaceBlend::Sample colours = blend_.at(triangle, u, v, front);
    const float part = reach_ ? reach_->part(point_of(model_.mesh(), triangle, u, v)) : 1;
    return {colours.dark + part * (colours.lit - colours.dark), colours.state};
  }

  const IntrinsicLumigraphSnapshot& model_;
  SurfaceBlend blend_;
  std::optional<LampReach> reach_;
};

/// Without a mesh the surface is where the views' depth has it, behind the picture plane.
class ImageShader : public ViewShader {
 public:
  ImageShader(const IntrinsicLumigraphSnapshot& model, ViewBlend blend, const Eigen::Vector3d& eye)
      : mesh_(model.shared_mesh()), data_(model.data()), blend_(std::move(blend)), eye_(eye.cast<float>()) {}
  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const auto seen = blend_.along(eye_, point_of(*mesh_, triangle, u, v));
    const auto colours = seen ? blend_.at(*seen) : std::nullopt;
    if (!colours) return inside_sample();  // beside all images nothing is known, either
    return {colours->lit, colours->known > 0 ? SampleState::kMeasured : SampleState::kUnseen};
  }
  SurfaceQuality quality(std::uint32_t) const override { return quality_of(*data_); }

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const LumigraphData> data_;
  ViewBlend blend_;
  Vector3f eye_;
};

/// The mean look, whatever the eye.
class MattShader : public ViewShader {
 public:
  explicit MattShader(MeanLook::Lit look) : look_(std::move(look)) {}
  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const MeanLook::Lit::Sample sample = look_.at(triangle, u, v);
    return {sample.lit, sample.state};
  }
  SurfaceQuality quality(std::uint32_t) const override { return {}; }

 private:
  MeanLook::Lit look_;
};

/// Of a model without images.
class NothingShader : public ViewShader {
 public:
  SurfaceSample shade(std::uint32_t, float, float) const override { return {}; }
  SurfaceQuality quality(std::uint32_t) const override { return {}; }
};

}  // namespace

IntrinsicLumigraphSnapshot::IntrinsicLumigraphSnapshot(std::shared_ptr<const Mesh> mesh,
                                                       std::shared_ptr<const Occluders> occluders,
                                                       std::shared_ptr<const LumigraphData> data, std::uint64_t version)
    : mesh_(std::move(mesh)), occluders_(std::move(occluders)), data_(std::move(data)), version_(version) {
  for (const auto& view : data_->views) cameras_.push_back(view->from);
  if (!data_->of_images && !data_->views.empty()) mean_look_ = std::make_shared<const MeanLook>(mesh_, *data_);
}

Eigen::Vector3d IntrinsicLumigraphSnapshot::light_place(const LightState& light) const {
  const LightSet& lights = data_->lights;
  if (light.kind != LightKind::kFixed) return lights.place_of(light);
  if (lights.size() == 0) return Eigen::Vector3d::UnitZ();
  Eigen::Index nearest = 0;
  (lights.places.colwise() - lights.places.rowwise().mean()).colwise().squaredNorm().minCoeff(&nearest);
  return lights.places.col(nearest);
}

std::vector<LightState> IntrinsicLumigraphSnapshot::lights() const {
  std::vector<LightState> lights;
  for (Eigen::Index i = 0; i < data_->lights.size(); ++i)
    lights.push_back({.kind = data_->lights.kind, .position = data_->lights.places.col(i)});
  return lights;
}

RelitView IntrinsicLumigraphSnapshot::relit(const IntrinsicView& view, const LightState& light) const {
  const Eigen::Vector3d place = light_place(light);
  RelitView relit = relight(view, data_->lights, place, in_parallel);
  scale(relit, light.rgb);
  if (!data_->of_images) return relit;
  return {shadowed(relit, predicted_arrival(*data_, view, place)), {}};
}

std::unique_ptr<ViewShader> IntrinsicLumigraphSnapshot::shader_for(const ViewQuery& query) const {
  if (empty()) return std::make_unique<NothingShader>();
  ViewBlend views(data_, query.eye, [&](const IntrinsicView& view) {
    return std::make_shared<const RelitView>(relit(view, query.light));
  });
  if (data_->of_images) return std::make_unique<ImageShader>(*this, std::move(views), query.eye);
  const Lamp lamp = data_->lights.lamp(light_place(query.light));
  return std::make_unique<MeshShader>(*this,
                                      SurfaceBlend(mesh_, std::move(views), mean_look_->in(lamp, query.light.rgb)),
                                      LampReach(*data_, occluders_, query.eye, lamp));
}

std::shared_ptr<const Appearance> IntrinsicLumigraphSnapshot::property(SurfaceProperty property) const {
  return std::make_shared<IntrinsicPictures>(std::make_shared<IntrinsicLumigraphSnapshot>(*this), property);
}

std::optional<AverageLook> IntrinsicLumigraphSnapshot::average_look() const {
  if (empty() || data_->of_images) return std::nullopt;
  return AverageLook{std::make_unique<MattShader>(mean_look_->in_all(data_->lights)), mesh_->vertices.size()};
}

SnapshotFigures IntrinsicLumigraphSnapshot::figures() const {
  if (empty()) return {};
  const auto lights = static_cast<int>(data_->lights.size());
  return {.median_rank = static_cast<double>(lights), .most_rank = lights, .seen = 1, .measured = 1};
}

std::size_t IntrinsicLumigraphSnapshot::memory_bytes() const {
  std::size_t bytes = mean_look_ ? mean_look_->bytes() : 0;
  for (const auto& view : data_->views) bytes += bytes_of(*view);
  return bytes;
}

std::shared_ptr<const ModelSnapshot> IntrinsicLumigraphSnapshot::filled() const {
  return std::make_shared<IntrinsicLumigraphSnapshot>(*this);  // points that no view shows have the mean look
}

ViewAdvice IntrinsicLumigraphSnapshot::advise_next_view(const Eigen::Vector3d& eye) const {
  return {.eye = eye,
          .heuristic = empty() ? 1.0 : std::min(1.0, data_->error / 0.1),
          .angle_deg = 0,
          .reason = "views and lights between those that there are say more",
          .worst_psnr_db = empty() ? 0 : -20 * std::log10(std::max(data_->error, 1e-6))};
}

std::unique_ptr<Compression> IntrinsicLumigraphSnapshot::compression(CompressionTarget) const {
  throw ConfigError("an intrinsic lumigraph has no smaller form");
}

void IntrinsicLumigraphSnapshot::save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                                      const StepsDone& progress) const {
  save_lumigraph(*this, folder, metadata, progress);
}

std::unique_ptr<ViewShader> InterpolatedImages::shader_for(const ViewQuery& query) const {
  if (model_->empty()) return std::make_unique<NothingShader>();
  const std::shared_ptr<const LumigraphData>& data = model_->data();
  const Eigen::Vector3d place = model_->light_place(query.light);
  ViewBlend views(data, query.eye, [&](const IntrinsicView& view) {
    RelitView relit;
    relit.lit = every_light_ ? mean_image(view, data->lights, in_parallel)
                             : interpolated_images(view, data->lights, place, in_parallel);
    scale(relit, every_light_ ? Eigen::Vector3f::Ones() : query.light.rgb);
    return std::make_shared<const RelitView>(std::move(relit));
  });
  if (data->of_images) return std::make_unique<ImageShader>(*model_, std::move(views), query.eye);
  return std::make_unique<MeshShader>(
      *model_, SurfaceBlend(model_->shared_mesh(), std::move(views), model_->mean_look().in_all(data->lights)),
      std::nullopt);
}

}  // namespace sheen
