// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace sheen {
namespace {

bool same_camera(const PosedCamera& a, const PosedCamera& b) {
  return a.camera == b.camera && a.camera_from_object.translation == b.camera_from_object.translation &&
         a.camera_from_object.rotation.coeffs() == b.camera_from_object.rotation.coeffs();
}

}  // namespace

void LumigraphPainter::look_from(const PosedCamera& from) {
  if (from_ && same_camera(*from_, from)) return;
  from_ = from;
  surface_.emplace(model_->occluders(), from);
  captured_ = nullptr;
  for (const auto& view : model_->data()->views)
    if (same_camera(view->from, from)) captured_ = view;
}

RelitView LumigraphPainter::blended(const std::function<RelitView(const LitView&)>& relit) const {
  if (captured_) return relit(*captured_);
  const ViewBlend blend(model_->data(), camera_centre(from_->camera_from_object), relit);
  const int w = from_->camera.width, h = from_->camera.height;
  RelitView out{ImageF(w, h, 3), ImageF(w, h, 3)};
  tbb::parallel_for(0, h, [&](int y) {
    for (int x = 0; x < w; ++x) {
      const auto point = surface_->point(x, y);
      if (!point) continue;
      const ViewBlend::Colours colours = blend.at(*point);
      Eigen::Vector3f::Map(out.lit.pixel(x, y)) = colours.lit;
      Eigen::Vector3f::Map(out.dark.pixel(x, y)) = colours.dark;
    }
  });
  return out;
}

ImageF LumigraphPainter::paint(const PosedCamera& from, const LightState& light) {
  look_from(from);
  const LightSet& lights = model_->data()->lights;
  const Eigen::Vector3d place = model_->light_place(light);
  RelitView relit = blended([&](const LitView& view) { return relight(view, lights, place); });
  scale(relit, light.rgb);
  return shadowed(relit, surface_->reached(lights, place));
}

ImageU8 LumigraphPainter::arrives(const PosedCamera& from, const LightState& light) {
  look_from(from);
  return surface_->reached(model_->data()->lights, model_->light_place(light));
}

ImageF LumigraphPainter::paint_interpolated(const PosedCamera& from, const LightState& light) {
  look_from(from);
  const Eigen::Vector3d place = model_->light_place(light);
  RelitView relit = blended([&](const LitView& view) {
    return RelitView{interpolated_images(view, model_->data()->lights, place), {}};
  });
  scale(relit, light.rgb);
  return std::move(relit.lit);
}

ImageU8 LumigraphPainter::interpolated_arrives(const PosedCamera& from, const LightState& light) {
  look_from(from);
  const Eigen::Vector3d place = model_->light_place(light);
  const RelitView relit = blended([&](const LitView& view) {
    return RelitView{interpolated_visibility(view, model_->data()->lights, place), {}};
  });
  ImageU8 out(from.camera.width, from.camera.height, 1);
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data()[i] = static_cast<std::uint8_t>(std::lround(255 * relit.lit.data()[3 * i]));
  return out;
}

}  // namespace sheen
