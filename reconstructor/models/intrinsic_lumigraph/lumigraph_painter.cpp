// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/depth_points.h"
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"
#include "reconstructor/models/intrinsic_lumigraph/surface_blend.h"

namespace sheen {
namespace {

bool same_light(const LightState& a, const LightState& b) {
  return a.kind == b.kind && a.position == b.position && a.rgb == b.rgb;
}

ImageU8 in_bytes(const ImageF& parts) {
  ImageU8 out(parts.width(), parts.height(), 1);
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data()[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(parts.data()[3 * i], 0.0f, 1.0f)));
  return out;
}

}  // namespace

void LumigraphPainter::look_from(const PosedCamera& from) {
  if (from_ && *from_ == from) return;
  from_ = from;
  surface_.reset();
  if (!model_->data()->of_images) surface_.emplace(*model_->shared_occluders(), from);
  captured_ = nullptr;
  for (const auto& view : model_->data()->views)
    if (same_place(view->from, from)) captured_ = view;
}

std::shared_ptr<const RelitView> LumigraphPainter::blended(const ViewBlend::Relight& relit,
                                                           std::optional<MeanLook::Lit> elsewhere) const {
  if (captured_) return relit(*captured_);
  const int w = from_->camera.width, h = from_->camera.height;
  auto out = std::make_shared<RelitView>(RelitView{ImageF(w, h, 3), ImageF(w, h, 3)});
  if (model_->empty()) return out;
  const auto put = [&](int x, int y, const LitAndDark& colours) {
    Eigen::Vector3f::Map(out->lit.pixel(x, y)) = colours.lit;
    Eigen::Vector3f::Map(out->dark.pixel(x, y)) = colours.dark;
  };
  ViewBlend views(model_->data(), camera_centre(from_->camera_from_object), relit);
  if (surface_) {
    const SurfaceBlend surface(model_->shared_mesh(), std::move(views), std::move(elsewhere));
    tbb::parallel_for(0, h, [&](int y) {
      for (int x = 0; x < w; ++x)
        if (const Hit hit = surface_->hit(x, y)) put(x, y, surface.at(hit.triangle, hit.u, hit.v, hit.front));
    });
    return out;
  }
  const DepthPoints rays(*from_);
  const float guess = static_cast<float>(std::max(1e-3, from_->camera_from_object.translation.z()));
  tbb::parallel_for(0, h, [&](int y) {
    for (int x = 0; x < w; ++x)
      if (const auto point = views.along(rays.eye(), rays.at(x, y, guess)))
        if (const auto colours = views.at(*point)) put(x, y, *colours);
  });
  return out;
}

ImageF LumigraphPainter::paint(const PosedCamera& from, const LightState& light) {
  look_from(from);
  auto before = std::exchange(relit_, {});
  if (!same_light(light, light_)) before.clear();
  light_ = light;
  std::optional<MeanLook::Lit> elsewhere;
  if (surface_ && !model_->empty()) elsewhere = model_->mean_look().in(lamp_of(light), light.rgb);
  const auto relit = blended(
      [&](const IntrinsicView& view) {
        const auto known = before.find(&view);
        return relit_[&view] = known != before.end() ? known->second
                                                     : std::make_shared<const RelitView>(model_->relit(view, light));
      },
      elsewhere);
  if (!surface_) return relit->lit;
  return shadowed(*relit, surface_->reached(lamp_of(light)));
}

Lamp LumigraphPainter::lamp_of(const LightState& light) const {
  return model_->data()->lights.lamp(model_->light_place(light));
}

ImageU8 LumigraphPainter::arrives(const PosedCamera& from, const LightState& light) {
  look_from(from);
  if (surface_) return surface_->reached(lamp_of(light));
  return in_bytes(blended([&](const IntrinsicView& view) {
                    const ImageU8 reached = predicted_arrival(*model_->data(), view, model_->light_place(light));
                    ImageF parts(reached.width(), reached.height(), 3);
                    for (std::size_t i = 0; i < parts.size(); ++i)
                      parts.data()[i] = static_cast<float>(reached.data()[i / 3]) / 255;
                    return std::make_shared<const RelitView>(RelitView{std::move(parts), {}});
                  })->lit);
}

ImageF LumigraphPainter::paint_interpolated(const PosedCamera& from, const LightState& light) {
  look_from(from);
  const Eigen::Vector3d place = model_->light_place(light);
  RelitView relit = *blended([&](const IntrinsicView& view) {
    return std::make_shared<const RelitView>(
        RelitView{interpolated_images(view, model_->data()->lights, place, in_parallel), {}});
  });
  scale(relit, light.rgb);
  return std::move(relit.lit);
}

ImageU8 LumigraphPainter::interpolated_arrives(const PosedCamera& from, const LightState& light) {
  look_from(from);
  const Eigen::Vector3d place = model_->light_place(light);
  return in_bytes(blended([&](const IntrinsicView& view) {
                    return std::make_shared<const RelitView>(
                        RelitView{interpolated_visibility(view, model_->data()->lights, place), {}});
                  })->lit);
}

}  // namespace sheen
