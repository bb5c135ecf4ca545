// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/progress.h"
#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/light_advice.h"
#include "reconstructor/models/surface_quality.h"

namespace sheen {

/// What a picture is asked for: from where, and in which light.
struct ViewQuery {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< object frame, metres
  LightState light = {};                          ///< fixed: the light in which the images were taken
  std::vector<LightState> more_lights = {};       ///< that are on together with it: their pictures add up
};

/// A surface as seen from one eye: cheap to ask point by point. Thread-safe.
class ViewShader {
 public:
  virtual ~ViewShader() = default;
  /// Radiance towards the eye at barycentric (u, v) of a triangle, of its front.
  virtual SurfaceSample shade(std::uint32_t triangle, float u, float v) const = 0;
  /// The same of its back. A model of what images show of fronts knows nothing of it.
  virtual SurfaceSample shade_back(std::uint32_t, float, float) const { return inside_sample(); }
  virtual SurfaceQuality quality(std::uint32_t triangle) const = 0;
};

/// How a mesh looks; immutable, shared between threads. It keeps alive all that it refers to.
class Appearance {
 public:
  virtual ~Appearance() = default;
  virtual const Mesh& mesh() const = 0;
  virtual std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const = 0;
};

/// A model of which a picture from every place on offer is predicted to have this PSNR is well known: more images
/// change little that a person sees.
inline constexpr double kWellKnownDb = 32;

/// Where the next image should be taken.
struct ViewAdvice {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< object frame
  double heuristic = 0;                           ///< mean over the surface seen from there, 0 = nothing to gain .. 1
  double angle_deg = 0;                           ///< from the present eye, seen from the object
  std::string reason;                             ///< for a person: what is missing there
  double worst_psnr_db = 0;                       ///< predicted of a picture from the least known place on offer
  bool well_known() const { return worst_psnr_db >= kWellKnownDb; }
};

/// How much of the surface is known, and in how many terms.
struct SnapshotFigures {
  double median_rank = 0;  ///< terms per patch, of the patches that an image has reached
  int most_rank = 0;
  double seen = 0;      ///< fraction of all samples that some image showed, 0..1
  double measured = 0;  ///< fraction of all samples that are more than imputed, 0..1
};

/// What a person or a script wants to know of a saved model later: source, date, settings. Keys and texts in UTF-8.
using ModelMetadata = std::map<std::string, std::string>;

class ModelSnapshot;

/// How a surface looks to all eyes and in all lights together.
struct AverageLook {
  std::unique_ptr<ViewShader> shader;
  std::size_t samples = 0;  ///< that the surface is known by
};

/// How small a model is to be made.
struct CompressionTarget {
  std::optional<double> bytes;  ///< of the file; without it, by what is lost
  double loss_db = 0.1;         ///< of the PSNR of the model's pictures
  /// PSNR (dB) of the pictures of a model, where there is something to judge it by.
  std::function<double(const ModelSnapshot&)> judge;
  /// That of the model's own, where they cannot be judged again; NaN: what the model predicts of them.
  double psnr_db = std::numeric_limits<double>::quiet_NaN();
  StepsDone progress = {};  ///< tries of the search, of as many as there can be
};
struct CompressedModel {
  std::shared_ptr<const ModelSnapshot> snapshot;  ///< its `save` writes one file
  double loss_db = 0;                             ///< as judged, or else as measured against the model
  std::size_t bytes = 0;                          ///< of that file, without what is noted in it
};

/// A model on its way into fewer bytes. It keeps what it needs of the model that it was made from, which need not stay.
class Compression {
 public:
  virtual ~Compression() = default;
  /// Throws ConfigError where it cannot be made so small.
  virtual CompressedModel run() = 0;
};

/// A model at one moment. Parts that did not change since the last snapshot are shared with it.
class ModelSnapshot : public Appearance {
 public:
  const Mesh& mesh() const override { return *shared_mesh(); }
  virtual const std::shared_ptr<const Mesh>& shared_mesh() const = 0;
  virtual std::uint64_t version() const = 0;  ///< counts up with every snapshot of a model
  virtual bool empty() const = 0;             ///< no image has reached it
  /// From where the images were taken that it was made of, in their order.
  virtual const std::vector<PosedCamera>& cameras() const = 0;
  virtual SnapshotFigures figures() const = 0;
  virtual std::size_t memory_bytes() const = 0;  ///< that it keeps; the mesh not counted
  /// Of the lights that a query may have: directional or point; fixed where it is the images' own, whatever is asked.
  virtual LightKind light_kind() const { return LightKind::kFixed; }
  /// In which the images were taken; none where a query's light does not count.
  virtual std::vector<LightState> lights() const { return {}; }
  /// None where the model knows no surface that is seen from all sides.
  virtual std::optional<AverageLook> average_look() const { return std::nullopt; }
  /// With a guess for what no image showed, for pictures that must have no holes; it stays marked as unseen.
  virtual std::shared_ptr<const ModelSnapshot> filled() const = 0;
  /// Where an image would be worth most, for a camera that is at `eye` now (object frame). Quick enough to be asked
  /// several times per second.
  virtual ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const = 0;
  /// Where the images' lights are too far apart for errors of at most so many grey levels (of 255, as shown); none
  /// where a query's light does not count, or where there are too few to say.
  virtual std::optional<LightAdvice> advise_next_light(double tolerance) const {
    static_cast<void>(tolerance);
    return std::nullopt;
  }
  /// The model in fewer bytes. Not asked where `ModelKind::compresses` says no.
  virtual std::unique_ptr<Compression> compression(CompressionTarget target) const = 0;
  /// The same at once.
  CompressedModel compressed(CompressionTarget target) const { return compression(std::move(target))->run(); }
  /// Writes the model into a folder, which is created where needed, whole or not at all: an older model stays until
  /// then. What is written is for `ModelKind::load`. Throws FileError.
  virtual void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                    const StepsDone& progress) const = 0;
};

}  // namespace sheen
