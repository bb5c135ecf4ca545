// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_pictures.h"

#include <optional>

#include "common/parallel/for_each.h"
#include "reconstructor/models/intrinsic_lumigraph/lamp_reach.h"
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

ImageF reflectance_of(const IntrinsicView& view) {
  ImageF out(view.depth.width(), view.depth.height(), 3);
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = static_cast<float>(view.reflectance.data()[i]);
  return out;
}

/// The part of each pixel that no light reaches.
ImageF shadow_of(const ImageU8& arrives) {
  ImageF out(arrives.width(), arrives.height(), 3);
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = 1 - static_cast<float>(arrives.data()[i / 3]) / 255;
  return out;
}

class PropertyShader : public ViewShader {
 public:
  PropertyShader(std::shared_ptr<const IntrinsicLumigraphSnapshot> model, SurfaceProperty property)
      : model_(std::move(model)), property_(property) {}
  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override { return at(triangle, u, v, 1); }
  SurfaceSample shade_back(std::uint32_t triangle, float u, float v) const override { return at(triangle, u, v, -1); }
  SurfaceQuality quality(std::uint32_t) const override { return {true, 0, 1, 1}; }

 protected:
  /// Of the mesh at a point, seen from the side of `facing` (unit).
  virtual SurfaceSample at(const Vector3f& point, const Vector3f& facing) const = 0;
  const IntrinsicLumigraphSnapshot& model() const { return *model_; }
  SurfaceProperty property() const { return property_; }

 private:
  SurfaceSample at(std::uint32_t triangle, float u, float v, float side) const {
    const Mesh& mesh = model_->mesh();
    return at((1 - u - v) * mesh.corner(triangle, 0) + u * mesh.corner(triangle, 1) + v * mesh.corner(triangle, 2),
              side * mesh.area_normal(triangle).normalized());
  }

  std::shared_ptr<const IntrinsicLumigraphSnapshot> model_;
  SurfaceProperty property_;
};

class OfMesh : public PropertyShader {
 public:
  OfMesh(std::shared_ptr<const IntrinsicLumigraphSnapshot> model, SurfaceProperty property, ViewBlend blend,
         LampReach reach)
      : PropertyShader(std::move(model), property), blend_(std::move(blend)), reach_(std::move(reach)) {}

 private:
  SurfaceSample at(const Vector3f& point, const Vector3f& facing) const override {
    if (property() == SurfaceProperty::kPlace) return {point, SampleState::kMeasured};
    if (property() == SurfaceProperty::kShadow)
      return {Vector3f::Constant(1 - reach_.part(point)), SampleState::kMeasured};
    const auto seen = blend_.at(point, facing);
    if (!seen || !(seen->known > 0)) return {};
    if (property() == SurfaceProperty::kReflectance) return {seen->lit, SampleState::kMeasured};
    return {seen->dark + reach_.part(point) * (seen->lit - seen->dark), SampleState::kMeasured};
  }

  ViewBlend blend_;
  LampReach reach_;
};

/// Without a mesh the surface is where the views' depth has it, behind the picture plane.
class OfImages : public PropertyShader {
 public:
  OfImages(std::shared_ptr<const IntrinsicLumigraphSnapshot> model, SurfaceProperty property, ViewBlend blend,
           const Eigen::Vector3d& eye)
      : PropertyShader(std::move(model), property), blend_(std::move(blend)), eye_(eye.cast<float>()) {}

 private:
  SurfaceSample at(const Vector3f& on_plane, const Vector3f&) const override {
    const auto place = blend_.along(eye_, on_plane);
    const auto seen = place ? blend_.at(*place) : std::nullopt;
    if (!seen || !(seen->known > 0)) return {};
    return {property() == SurfaceProperty::kPlace ? *place : seen->lit, SampleState::kMeasured};
  }

  ViewBlend blend_;
  Vector3f eye_;
};

/// Of a model without images.
class NothingKnown : public ViewShader {
 public:
  SurfaceSample shade(std::uint32_t, float, float) const override { return {}; }
  SurfaceQuality quality(std::uint32_t) const override { return {}; }
};

}  // namespace

RelitView IntrinsicPictures::of_view(const IntrinsicView& view, const LightState& light) const {
  const LumigraphData& data = *model_->data();
  const Eigen::Vector3d place = model_->light_place(light);
  if (property_ == SurfaceProperty::kShadow && data.of_images)
    return {shadow_of(predicted_arrival(data, view, place)), {}};
  if (property_ != SurfaceProperty::kIllumination) return {reflectance_of(view), {}};
  RelitView illumination = illuminated(view, data.lights, place, in_parallel);
  scale(illumination, light.rgb);
  if (!data.of_images) return illumination;
  return {shadowed(illumination, predicted_arrival(data, view, place)), {}};
}

std::unique_ptr<ViewShader> IntrinsicPictures::shader_for(const ViewQuery& query) const {
  if (model_->empty()) return std::make_unique<NothingKnown>();
  const std::shared_ptr<const LumigraphData>& data = model_->data();
  ViewBlend views(data, query.eye, [&](const IntrinsicView& view) {
    return std::make_shared<const RelitView>(of_view(view, query.light));
  });
  if (data->of_images) return std::make_unique<OfImages>(model_, property_, std::move(views), query.eye);
  return std::make_unique<OfMesh>(
      model_, property_, std::move(views),
      LampReach(*data, model_->shared_occluders(), query.eye, data->lights.lamp(model_->light_place(query.light))));
}

}  // namespace sheen
