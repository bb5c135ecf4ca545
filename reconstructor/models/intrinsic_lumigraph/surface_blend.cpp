// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/surface_blend.h"

#include <algorithm>

#include "reconstructor/models/surface_quality.h"

namespace sheen {
namespace {

/// Of the views' weights: where so much of them shows a point, they alone count.
constexpr float kKnown = 0.1f;

SurfaceBlend::Sample inside() {
  SurfaceBlend::Sample grey;
  grey.lit = grey.dark = inside_sample().rgb;
  return grey;
}

}  // namespace

SurfaceBlend::Sample SurfaceBlend::at(std::uint32_t triangle, float u, float v, bool front) const {
  const Eigen::Vector3f normal = mesh_->area_normal(triangle).normalized();
  const Eigen::Vector3f point =
      (1 - u - v) * mesh_->corner(triangle, 0) + u * mesh_->corner(triangle, 1) + v * mesh_->corner(triangle, 2);
  const ViewBlend::Colours near = views_.at(point, front ? normal : -normal).value_or(ViewBlend::Colours{});
  const float part = elsewhere_ || !front ? std::min(1.0f, near.known / kKnown) : 1;
  Sample sample;
  if (part < 1) sample = front ? elsewhere_->at(triangle, u, v) : inside();
  sample.lit = part * near.lit + (1 - part) * sample.lit;
  sample.dark = part * near.dark + (1 - part) * sample.dark;
  if (part >= 0.5f) sample.state = SampleState::kMeasured;
  return sample;
}

}  // namespace sheen
