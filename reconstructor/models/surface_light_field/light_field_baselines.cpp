// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/light_field_baselines.h"

#include "reconstructor/models/photograph_coding.h"

namespace sheen {

LightFieldBaselines::LightFieldBaselines(std::shared_ptr<const LightFieldSnapshot> model,
                                         const SurfaceLightFieldOptions& options, bool photographs)
    : model_(std::move(model)),
      sampling_(options.sampling),
      visibility_(model_->mesh(), model_->maps(), options.visibility),
      mean_(std::make_shared<ConstantColour>(model_->shared_mesh(), model_->shared_maps())) {
  if (photographs) photographs_ = std::make_shared<PhotographSet>(model_->shared_mesh(), options.visibility);
}

void LightFieldBaselines::add(const Capture& capture, float exposure_gain, bool repeated) {
  const SurfaceView& view = visibility_.look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  if (!repeated) {
    image_.load(capture, view);
    mean_->add({image_, view, model_->maps(), exposure_gain, sampling_});
  }
  if (photographs_) photographs_->add(capture, level_radiance(capture, exposure_gain), view);
}

std::vector<Baseline> LightFieldBaselines::from_photographs(std::size_t model_bytes) const {
  if (!photographs_) return {};
  const std::shared_ptr<const Appearance> constant = constant_colour();
  const auto disk = static_cast<double>(photographs_->pixel_bytes()),
             memory = static_cast<double>(photographs_->memory_bytes());
  const CodedPhotographs coded = code_photographs(*photographs_, model_bytes);
  return {
      {"nearest_photograph", "nearest photograph (all kept)", PhotographSet::nearest_photograph(photographs_, constant),
       disk, memory},
      {"lumigraph_of_model_bytes", "lumigraph of as many bytes (photographs as WebP)",
       PhotographSet::unstructured_lumigraph(coded.photographs, constant), static_cast<double>(coded.bytes), memory},
      {"unstructured_lumigraph", "unstructured lumigraph (4 nearest, all kept)",
       PhotographSet::unstructured_lumigraph(photographs_, constant), disk, memory}};
}

BaselineHeuristic LightFieldBaselines::heuristic() const {
  const auto paper = std::make_shared<PaperHeuristic>(*model_);
  return {"the paper's heuristic",
          [model = model_, paper](const Eigen::Vector3d& eye) { return paper->seen_from(eye); }};
}

}  // namespace sheen
