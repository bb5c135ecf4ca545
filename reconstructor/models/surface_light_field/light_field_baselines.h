// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "reconstructor/models/baselines.h"
#include "reconstructor/models/photographs.h"
#include "reconstructor/models/surface_light_field/constant_colour.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/models/surface_light_field/paper_heuristic.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {

/// What a surface light field is compared with: the mean of each of its samples over the images that it was built from,
/// and, with `photographs`, the nearest photograph and the unstructured lumigraph, which keep them all: the lumigraph
/// also with photographs that take no more bytes than the model.
class LightFieldBaselines : public Baselines {
 public:
  LightFieldBaselines(std::shared_ptr<const LightFieldSnapshot> model, const SurfaceLightFieldOptions& options,
                      bool photographs);

  void add(const Capture& capture, float exposure_gain, bool repeated) override;
  std::shared_ptr<const Appearance> constant_colour() const override {
    return appearance_of(mean_, model_->exposure());
  }
  std::vector<Baseline> from_photographs(std::size_t model_bytes) const override;
  BaselineHeuristic heuristic() const override;

 private:
  std::shared_ptr<const LightFieldSnapshot> model_;
  Sampling sampling_;
  SampleVisibility visibility_;
  std::shared_ptr<ConstantColour> mean_;
  std::shared_ptr<PhotographSet> photographs_;  ///< null where they are not asked for
  RadianceImage image_;
};

}  // namespace sheen
