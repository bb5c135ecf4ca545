// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_options.h"

#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"

namespace sheen {
namespace {

/// What is compared with: the captured images, in the mean of all lights and interpolated between them.
class CapturedImages : public Baselines {
 public:
  explicit CapturedImages(const std::shared_ptr<const ModelSnapshot>& model)
      : model_(std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model)) {}
  void add(const Capture& capture, float, bool) override { bytes_ += static_cast<double>(capture.image.bytes.size()); }
  std::shared_ptr<const Appearance> constant_colour() const override {
    return std::make_shared<InterpolatedImages>(model_, true);
  }
  std::vector<Baseline> from_photographs(std::size_t) const override {
    return {{"linear_interpolation", "linear interpolation of images",
             std::make_shared<InterpolatedImages>(model_, false), bytes_, bytes_}};
  }
  BaselineHeuristic heuristic() const override {
    return {"none", [n = model_->mesh().triangles.size()](const auto&) { return std::vector<float>(n, 0.5f); }};
  }

 private:
  std::shared_ptr<const IntrinsicLumigraphSnapshot> model_;
  double bytes_ = 0;
};

}  // namespace

std::optional<Mesh> IntrinsicLumigraphOptions::own_mesh(const PosedCamera& camera) const {
  return view_plane(camera);
}

std::unique_ptr<AppearanceModel> IntrinsicLumigraphOptions::make_model(
    std::shared_ptr<const Mesh> mesh, std::shared_ptr<const RayScene> /*scene*/) const {
  return std::make_unique<IntrinsicLumigraph>(std::move(mesh), *this);
}

std::unique_ptr<Baselines> IntrinsicLumigraphOptions::make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                                                     bool) const {
  return std::make_unique<CapturedImages>(snapshot);
}

}  // namespace sheen
