// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

namespace sheen {

/// Pictures of a lumigraph in quick succession: what a camera sees is kept while the light moves, and
/// the views' colours while the eye does. Paints what a ray
/// painter makes of the snapshot. Throws ConfigError for a light of another kind.
class LumigraphPainter {
 public:
  explicit LumigraphPainter(std::shared_ptr<const IntrinsicLumigraphSnapshot> model) : model_(std::move(model)) {}

  /// Linear RGB; black where there is no surface.
  ImageF paint(const PosedCamera& from, const LightState& light);
  /// Part of each pixel that the light reaches, 0..255, as the model predicts it.
  ImageU8 arrives(const PosedCamera& from, const LightState& light);
  /// The same of linear interpolation between the captured lights: what both are compared with.
  ImageF paint_interpolated(const PosedCamera& from, const LightState& light);
  ImageU8 interpolated_arrives(const PosedCamera& from, const LightState& light);

  const std::shared_ptr<const IntrinsicLumigraphSnapshot>& model() const { return model_; }

 private:
  Lamp lamp_of(const LightState& light) const;
  void look_from(const PosedCamera& from);
  /// Colours of the views as `relit` makes them, seen from there; of a mesh `elsewhere` is what no view shows.
  std::shared_ptr<const RelitView> blended(const ViewBlend::Relight& relit,
                                           std::optional<MeanLook::Lit> elsewhere = {}) const;

  std::shared_ptr<const IntrinsicLumigraphSnapshot> model_;
  std::optional<PosedCamera> from_;
  std::optional<SeenSurface> surface_;             ///< from there
  std::shared_ptr<const IntrinsicView> captured_;  ///< the view that was taken from there, if any
  LightState light_;                               ///< of the relit views
  std::map<const IntrinsicView*, std::shared_ptr<const RelitView>> relit_;  ///< those of the last picture
};

}  // namespace sheen
