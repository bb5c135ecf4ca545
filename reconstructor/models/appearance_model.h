// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <memory>
#include <string>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"

namespace sheen {

enum class IngestStatus {
  kAccepted,  ///< folded into the model
  kHeldOut,   ///< accepted, and kept aside to judge the model
  kRefused,   ///< see `reason`
};

/// What became of one capture.
struct IngestReport {
  IngestStatus status = IngestStatus::kRefused;
  std::string reason;                      ///< of a refusal: a short, stable word ("object_not_in_view", ...)
  std::map<std::string, double> stage_ms;  ///< time a stage of the pipeline
  std::size_t rings_updated = 0;
  std::size_t rings_skipped = 0;   ///< the image shows of them what an earlier one showed from the same direction
  std::size_t rings_left_out = 0;  ///< for want of time (`SurfaceLightField::set_share`)
  double relative_residual = 0;  ///< ||p|| / ||c|| over all updated rings: how much of the image the model did not know
  /// PSNR, encoded values, of foretelling a sample of the image from the images before it: the held-out figure, live.
  /// NaN where the model knew nothing of what the image shows.
  double foretold_psnr_db = std::numeric_limits<double>::quiet_NaN();
  float exposure_gain = 1;  ///< by which this image is brighter than the model's level, as the camera or the image says
};

/// How well a part of the surface is known, and why it is not.
enum class QualityReason : std::uint8_t {
  kGood = 0,
  kUnseen = 1,            ///< no image shows it
  kOblique = 2,           ///< seen only at grazing angles
  kSparseDirections = 3,  ///< no image from near the asked direction
  kHighResidual = 4,      ///< images still bring what the model does not know
};
const char* to_string(QualityReason reason);

/// What is known of a part of the surface from one direction.
struct SurfaceQuality {
  bool seen = false;
  float error = 0.14f;        ///< RMS of encoded values by which it is expected to be wrong; 0.14 of a guess
  float nearest_cosine = -1;  ///< of the angle to the nearest image's direction
  float best_cosine = 0;      ///< of the most frontal image; 0..1

  /// The quality heuristic, 0 = well known .. 1 = not at all: the error over 0.1 (20 dB); 1 where nothing was seen.
  float heuristic() const;
  QualityReason reason() const;
};

/// What the colour of a surface sample rests on.
enum class SampleState : std::uint8_t {
  kUnseen = 0,    ///< no image shows the sample: its colour is a guess
  kImputed = 1,   ///< fewer than half of the images round it do: how it changes with the view is mostly inferred
  kMeasured = 2,  ///< at least half of them do
};

/// One surface point as the model knows it.
struct SurfaceSample {
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();  ///< linear radiance
  SampleState state = SampleState::kUnseen;
};

/// The model as seen from one eye: cheap to ask point by point. Thread-safe.
class ViewShader {
 public:
  virtual ~ViewShader() = default;
  /// Radiance towards the eye at barycentric (u, v) of a triangle.
  virtual SurfaceSample shade(std::uint32_t triangle, float u, float v) const = 0;
  virtual SurfaceQuality quality(std::uint32_t triangle) const = 0;
};

/// A model at one moment; immutable, shared between threads. It keeps alive all that it refers to.
class ModelSnapshot {
 public:
  virtual ~ModelSnapshot() = default;
  virtual const Mesh& mesh() const = 0;
  /// `eye` in the object frame.
  virtual std::unique_ptr<ViewShader> shader_for(const Eigen::Vector3d& eye) const = 0;
};

/// The one interface of a model to the capture loop.
class AppearanceModel {
 public:
  virtual ~AppearanceModel() = default;
  /// Folds one image in. Never throws for what a frame can hold; the report says why it was refused.
  virtual IngestReport ingest(const Capture& capture) = 0;
  /// The model as it now stands. Parts that did not change since the last snapshot are shared with it.
  virtual std::shared_ptr<const ModelSnapshot> snapshot() = 0;
};

}  // namespace sheen
