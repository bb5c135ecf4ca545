// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "common/simulation/light_rig.h"
#include "common/simulation/light_rig_capture.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"

namespace sheen {

/// A rig that is quick to render, and a lumigraph of all of its images.
struct SmallRig {
  LightRig rig{{.lights = 7, .columns = 2, .rows = 1, .width = 160, .height = 120}};
  std::shared_ptr<const Mesh> mesh = std::make_shared<const Mesh>(rig.scene().mesh);

  Capture capture(std::size_t view, std::size_t light) const {
    return rig_capture(rig.cameras()[view], rig.lights()[light],
                       rig.picture(rig.cameras()[view], rig.lights()[light]).radiance,
                       view * rig.lights().size() + light + 1);
  }
  std::unique_ptr<IntrinsicLumigraph> model() const {
    auto model = std::make_unique<IntrinsicLumigraph>(mesh, IntrinsicLumigraphOptions());
    for (std::size_t v = 0; v < rig.cameras().size(); ++v)
      for (std::size_t l = 0; l < rig.lights().size(); ++l) model->ingest(capture(v, l));
    return model;
  }
  static std::shared_ptr<const IntrinsicLumigraphSnapshot> snapshot_of(IntrinsicLumigraph& model) {
    return std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model.snapshot());
  }
};

}  // namespace sheen
