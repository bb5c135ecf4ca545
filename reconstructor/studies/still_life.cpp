// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/still_life.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/light_rig_capture.h"
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"

namespace sheen {
namespace {

/// In the order of `rig_captures`.
Capture capture_of(const LightRig& rig, std::size_t index) {
  const PosedCamera& from = rig.cameras()[index / rig.lights().size()];
  const LightState& light = rig.lights()[index % rig.lights().size()];
  return rig_capture(from, light, rig.picture(from, light).radiance, index + 1);
}

std::size_t count_of(const LightRig& rig) {
  return rig.cameras().size() * rig.lights().size();
}

}  // namespace

std::vector<Capture> rig_captures(const LightRig& rig) {
  std::vector<Capture> captures;
  for (std::size_t i = 0; i < count_of(rig); ++i) captures.push_back(capture_of(rig, i));
  return captures;
}

StillLife::StillLife(const LightRigOptions& options, std::shared_ptr<const Mesh> mesh) : rig(options) {
  if (!mesh) mesh = std::make_shared<const Mesh>(view_plane(rig.central_camera()));
  IntrinsicLumigraph lumigraph(mesh, {});
  for (std::size_t i = 0; i < count_of(rig); ++i) lumigraph.ingest(capture_of(rig, i));
  model = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(lumigraph.snapshot());
}

LinearPicture interpolated_truth(const LightRig& rig, const PosedCamera& from, double place) {
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, rig.lights().size() - 2.0));
  const Camera& camera = from.camera;
  LinearPicture out{ImageF(camera.width, camera.height, 3), ImageF(camera.width, camera.height, 1)};
  for (const std::size_t l : {before, before + 1}) {
    const auto weight = static_cast<float>(1 - std::abs(place - static_cast<double>(l)));
    const SimulatedPicture picture = rig.picture(from, rig.lights()[l]);
    for (std::size_t i = 0; i < out.radiance.size(); ++i) out.radiance.data()[i] += weight * picture.radiance.data()[i];
    for (std::size_t i = 0; i < out.arrives.size(); ++i) out.arrives.data()[i] += picture.shadow.data()[i] ? 0 : weight;
  }
  return out;
}

}  // namespace sheen
