// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/irradiance_field_options.h"

#include "reconstructor/models/irradiance_field/irradiance_field.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"

namespace sheen {
namespace {

/// What is compared with: the same picture in every light. That of all lights together is the mean.
class SameInEveryLight : public Baselines {
 public:
  explicit SameInEveryLight(std::shared_ptr<const ModelSnapshot> model) : model_(std::move(model)) {}
  void add(const Capture&, float, bool) override {}
  std::shared_ptr<const Appearance> constant_colour() const override {
    const auto& field = dynamic_cast<const IrradianceFieldSnapshot&>(*model_);
    return std::make_shared<FlatPicture>(field.shared_mesh(), field.picture({}), 0.14f);
  }
  std::vector<Baseline> from_photographs(std::size_t) const override { return {}; }
  BaselineHeuristic heuristic() const override {
    return {"none", [n = model_->mesh().triangles.size()](const auto&) { return std::vector<float>(n, 0.5f); }};
  }

 private:
  std::shared_ptr<const ModelSnapshot> model_;
};

}  // namespace

std::optional<Mesh> IrradianceFieldOptions::own_mesh(const PosedCamera& camera) const {
  Mesh plane = picture_plane(Undistortion(camera).camera());
  require_no_origin("the images' camera", plane);
  return plane;
}

std::unique_ptr<AppearanceModel> IrradianceFieldOptions::make_model(std::shared_ptr<const Mesh> mesh,
                                                                    std::shared_ptr<const RayScene> /*scene*/) const {
  return std::make_unique<IrradianceField>(std::move(mesh), *this);
}

std::unique_ptr<Baselines> IrradianceFieldOptions::make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                                                  bool) const {
  return std::make_unique<SameInEveryLight>(std::move(snapshot));
}

}  // namespace sheen
