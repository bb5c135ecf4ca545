// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/intrinsic_lumigraph/captured_view.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_options.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"

namespace sheen {

/// The intrinsic lumigraph as it is built (001): a few lights, each seen by the same grid or path of cameras. It keeps
/// all images; they are taken apart when a snapshot is asked for. With a mesh it says where the surface is and what
/// hides the lamps; without one (`view_plane`) the images do.
class IntrinsicLumigraph : public AppearanceModel {
 public:
  IntrinsicLumigraph(std::shared_ptr<const Mesh> mesh, const IntrinsicLumigraphOptions& options);

  /// Refuses as "no_pose", "no_light_position", "other_kind_of_light", "broken_light", "same_view_and_light",
  /// "broken_pixels" (not finite).
  IngestReport ingest(const Capture& capture) override;
  bool withdraw(const Capture& capture) override;
  bool began_with(const Capture& capture) const override;
  void restart(int effort_level) override;
  std::shared_ptr<const ModelSnapshot> snapshot() override;
  std::shared_ptr<const Appearance> constant_colour() const override;
  const ModelSettings& settings() const override { return options_; }
  ModelFigures figures() const override;
  MemoryAccount memory(const CaptureSize& image) const override;

 private:
  struct LitImage {
    std::string source_session;
    std::uint64_t sequence = 0;
    LightState light;
    ImageHalf radiance;  ///< linear RGB in a light of brightness 1
  };
  struct View {
    PosedCamera from;
    std::vector<LitImage> images;
  };
  std::string refusal(const Capture& capture) const;
  View* view_of(const Capture& capture);
  LightSet light_set() const;
  /// A view's images, not yet where its surface lies and which lights arrive.
  CapturedView captured(const View& view, const LightSet& lights) const;
  LumigraphData on_mesh(const LightSet& lights) const;

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const Occluders> occluders_;  ///< null without a mesh
  IntrinsicLumigraphOptions options_;
  std::vector<View> views_;
  std::pair<std::string, std::uint64_t> first_{};  ///< session and sequence of the first image
  std::uint64_t version_ = 0;
  std::shared_ptr<const IntrinsicLumigraphSnapshot> newest_;  ///< null where an image came or went since
};

}  // namespace sheen
