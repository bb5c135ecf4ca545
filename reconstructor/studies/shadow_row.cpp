// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/shadow_row.h"

#include <cmath>

#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/models/intrinsic_lumigraph/seen_surface.h"
#include "reconstructor/studies/shadow_warp.h"

namespace sheen {

const IntrinsicView& central_view(const StillLife& scene) {
  return *scene.model->data()->views[scene.rig.cameras().size() / 2];
}

ImageU8 inverse(ImageU8 image) {
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<std::uint8_t>(255 - image.data()[i]);
  return image;
}

double iou(const ImageU8& shadow, const ImageU8& truth) {
  Overlap overlap;
  for (std::size_t i = 0; i < truth.size(); ++i) overlap.add(shadow.data()[i] >= 128, truth.data()[i] >= 128);
  return overlap.iou();
}

ShadowRow shadows_between(const StillLife& scene, std::size_t first_light) {
  const PosedCamera from = scene.rig.central_camera();
  const IntrinsicView& view = central_view(scene);
  const Occluders surface(depth_surface(from, view.depth));
  const SeenSurface seen(surface, from);
  LumigraphPainter painter(scene.model);
  ShadowRow row;
  for (int k = 0; k <= ShadowRow::kSteps; ++k) {
    row.places.push_back(static_cast<double>(first_light) + static_cast<double>(k) / ShadowRow::kSteps);
    const LightState light = scene.rig.light_at(row.places.back());
    row.truth.push_back(scene.rig.picture(from, light).shadow);
    row.geometric.push_back(inverse(seen.reached(scene.model->data()->lights.lamp(scene.model->light_place(light)))));
    row.lumigraph.push_back(inverse(painter.arrives(from, light)));
  }
  for (const double place : row.places) {
    const double part = place - row.places.front();
    ImageU8& linear = row.linear.emplace_back(row.truth.front());
    for (std::size_t i = 0; i < linear.size(); ++i)
      linear.data()[i] = static_cast<std::uint8_t>(
          std::lround(std::lerp(double(row.truth.front().data()[i]), double(row.truth.back().data()[i]), part)));
  }
  row.warped = warped_shadows(row.geometric, row.lumigraph.front(), row.lumigraph.back());
  return row;
}

}  // namespace sheen
