// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr float kGuess = 0.14f;  // RMS of encoded values of what is not known

Vector3f point_of(const Mesh& mesh, std::uint32_t triangle, float u, float v) {
  return (1 - u - v) * mesh.corner(triangle, 0) + u * mesh.corner(triangle, 1) + v * mesh.corner(triangle, 2);
}

class BlendShader : public ViewShader {
 public:
  BlendShader(const IntrinsicLumigraphSnapshot& model, ViewBlend blend, const Eigen::Vector3d& eye)
      : model_(model), data_(model.data()), blend_(std::move(blend)), eye_(eye.cast<float>()) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    if (blend_.empty()) return {};
    const Vector3f point = point_of(model_.mesh(), triangle, u, v);
    if (!data_->of_images) return sample(point, model_.mesh().area_normal(triangle));
    const auto seen = blend_.along(eye_, point);
    return seen ? sample(*seen, Vector3f::Zero()) : SurfaceSample{};
  }
  /// Images may show the inside of an open object, too.
  SurfaceSample shade_back(std::uint32_t triangle, float u, float v) const override {
    if (blend_.empty() || data_->of_images) return inside_sample();
    const SurfaceSample inside = sample(point_of(model_.mesh(), triangle, u, v), -model_.mesh().area_normal(triangle));
    return inside.state == SampleState::kUnseen ? inside_sample() : inside;
  }
  SurfaceQuality quality(std::uint32_t) const override {
    return blend_.empty() ? SurfaceQuality{} : SurfaceQuality{true, static_cast<float>(data_->error), 1, 1};
  }

 protected:
  SurfaceSample sample(const Vector3f& point, const Vector3f& facing) const {
    const ViewBlend::Colours colours = blend_.at(point, facing);
    const float part = part_reached(point);
    return {colours.dark + part * (colours.lit - colours.dark),
            colours.seen ? SampleState::kMeasured : SampleState::kUnseen};
  }
  /// Of what a pixel round the point shows, how much the light reaches, 0..1.
  virtual float part_reached(const Vector3f& point) const = 0;

  const IntrinsicLumigraphSnapshot& model_;
  std::shared_ptr<const LumigraphData> data_;
  ViewBlend blend_;
  Vector3f eye_;
};

/// Visibility by rays, over the footprint of a pixel of the nearest view.
class RayShadowShader : public BlendShader {
 public:
  RayShadowShader(const IntrinsicLumigraphSnapshot& model, ViewBlend blend, const Eigen::Vector3d& eye,
                  const Lamp& lamp)
      : BlendShader(model, std::move(blend), eye), lamp_(lamp) {
    if (blend_.empty()) return;
    const PosedCamera& near = blend_.nearest().from;
    object_from_camera_ = near.camera_from_object.rotation.conjugate().toRotationMatrix().cast<float>();
    pixel_ = {static_cast<float>(1 / near.camera.fx), static_cast<float>(1 / near.camera.fy)};
  }

 protected:
  float part_reached(const Vector3f& point) const override {
    constexpr int kSide = 4;
    const Vector3f direction = point - eye_;
    const float depth = object_from_camera_.col(2).dot(direction);
    const auto reached = [&](float x, float y) {
      const Ray ray{eye_, direction + depth * (x * pixel_.x() * object_from_camera_.col(0) +
                                               y * pixel_.y() * object_from_camera_.col(1))};
      const Hit hit = model_.occluders().rays().intersect(ray);
      if (!hit) return false;
      const Occluders::Place seen = model_.occluders().place_or_none(ray, hit);
      return model_.occluders().reached(seen, lamp_);
    };
    int corners = 0;
    for (const float y : {-0.5f, 0.5f})
      for (const float x : {-0.5f, 0.5f}) corners += reached(x, y);
    if (corners == 0 || corners == 4) return static_cast<float>(corners) / 4;
    int count = 0;
    for (int k = 0; k < kSide * kSide; ++k)
      count += reached((static_cast<float>(k % kSide) + 0.5f) / kSide - 0.5f,
                       (static_cast<float>(k / kSide) + 0.5f) / kSide - 0.5f);
    return static_cast<float>(count) / (kSide * kSide);
  }

 private:
  Lamp lamp_;
  Eigen::Matrix3f object_from_camera_ = Eigen::Matrix3f::Identity();
  Eigen::Vector2f pixel_{0, 0};
};

/// Colours that are what they are in light and shadow.
class PlainShader : public BlendShader {
 public:
  using BlendShader::BlendShader;

 protected:
  float part_reached(const Vector3f&) const override { return 1; }
};

}  // namespace

IntrinsicLumigraphSnapshot::IntrinsicLumigraphSnapshot(std::shared_ptr<const Mesh> mesh,
                                                       std::shared_ptr<const Occluders> occluders,
                                                       std::shared_ptr<const LumigraphData> data, std::uint64_t version)
    : mesh_(std::move(mesh)), occluders_(std::move(occluders)), data_(std::move(data)), version_(version) {
  for (const auto& view : data_->views) cameras_.push_back(view->from);
}

Eigen::Vector3d IntrinsicLumigraphSnapshot::light_place(const LightState& light) const {
  const LightSet& lights = data_->lights;
  if (light.kind != LightKind::kFixed) return lights.place_of(light);
  if (lights.size() == 0) return Eigen::Vector3d::UnitZ();
  Eigen::Index nearest = 0;
  (lights.places.colwise() - lights.places.rowwise().mean()).colwise().squaredNorm().minCoeff(&nearest);
  return lights.places.col(nearest);
}

RelitView IntrinsicLumigraphSnapshot::relit(const IntrinsicView& view, const LightState& light) const {
  const Eigen::Vector3d place = light_place(light);
  RelitView relit = relight(view, data_->lights, place);
  scale(relit, light.rgb);
  if (!data_->of_images) return relit;
  return {shadowed(relit, predicted_arrival(*data_, view, place)), {}};
}

std::unique_ptr<ViewShader> IntrinsicLumigraphSnapshot::shader_for(const ViewQuery& query) const {
  const Lamp lamp = data_->lights.lamp(light_place(query.light));
  ViewBlend blend(data_, query.eye, [&](const IntrinsicView& view) {
    return std::make_shared<const RelitView>(relit(view, query.light));
  });
  if (data_->of_images) return std::make_unique<PlainShader>(*this, std::move(blend), query.eye);
  return std::make_unique<RayShadowShader>(*this, std::move(blend), query.eye, lamp);
}

SnapshotFigures IntrinsicLumigraphSnapshot::figures() const {
  if (empty()) return {};
  const auto lights = static_cast<int>(data_->lights.size());
  return {.median_rank = static_cast<double>(lights), .most_rank = lights, .seen = 1, .measured = 1};
}

std::size_t IntrinsicLumigraphSnapshot::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& view : data_->views) bytes += bytes_of(*view);
  return bytes;
}

std::shared_ptr<const ModelSnapshot> IntrinsicLumigraphSnapshot::filled() const {
  return std::make_shared<IntrinsicLumigraphSnapshot>(*this);  // points that no view shows take a neighbour's colour
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
  const std::shared_ptr<const LumigraphData>& data = model_->data();
  const Eigen::Vector3d place = model_->light_place(query.light);
  return std::make_unique<PlainShader>(
      *model_,
      ViewBlend(data, query.eye,
                [&](const IntrinsicView& view) {
                  RelitView relit;
                  relit.lit =
                      every_light_ ? mean_image(view, data->lights) : interpolated_images(view, data->lights, place);
                  scale(relit, every_light_ ? Eigen::Vector3f::Ones() : query.light.rgb);
                  return std::make_shared<const RelitView>(std::move(relit));
                }),
      query.eye);
}

}  // namespace sheen
