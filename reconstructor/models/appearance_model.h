// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "reconstructor/models/memory_account.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

enum class IngestStatus {
  kAccepted,  ///< added to the model
  kHeldOut,   ///< accepted, and held out to judge the model
  kRefused,   ///< see `reason`
};

/// What became of one capture. A patch is a part of the surface that the model updates by itself.
struct IngestReport {
  IngestStatus status = IngestStatus::kRefused;
  std::string reason;                      ///< of a refusal: a short, stable word ("object_not_in_view", ...)
  std::map<std::string, double> stage_ms;  ///< time per stage of the pipeline
  bool repeated = false;                   ///< accepted, but nothing of it was used: it shows what an earlier one does
  std::size_t patches_updated = 0;
  std::size_t patches_skipped = 0;   ///< the image shows of them what an earlier one showed from the same direction
  std::size_t patches_left_out = 0;  ///< for want of time (`AppearanceModel::set_update_fraction`)
  double relative_residual =
      0;  ///< ||p|| / ||c|| over all updated patches: how much of the image the model did not know
  /// PSNR, encoded values, of predicting a sample of the image from the images before it: the held-out figure, live.
  /// NaN where the model knew nothing of what the image shows.
  double predicted_psnr_db = std::numeric_limits<double>::quiet_NaN();
  float exposure_gain = 1;  ///< by which this image is brighter than the model's level, as the camera or the image says
};

/// What a model holds.
struct ModelFigures {
  std::size_t images = 0;                   ///< ingested
  std::vector<std::size_t> rank_histogram;  ///< [patches of rank 0, 1, ...], those that no image reached left out
  std::size_t bytes = 0;                    ///< of what it has learned
  double bytes_per_patch = 0;               ///< mean over the patches that an image reached
};

struct ModelSettings;

/// The one interface of a model to the capture loop, the commands and the displays. It is a function of the captures,
/// their order, the effort level and the update fraction at each.
class AppearanceModel {
 public:
  virtual ~AppearanceModel() = default;

  /// Ingests one image. Never throws for what a frame can hold; the report says why it was refused.
  virtual IngestReport ingest(const Capture& capture) = 0;
  /// Takes out an image that was ingested, in about the time of ingesting one. The result is nearly, not to the bit,
  /// that of never having seen it. False when only a rebuilt model would do.
  virtual bool withdraw(const Capture& capture) = 0;
  /// Whether this is the first image that showed something: it may have decided what lasts.
  virtual bool began_with(const Capture& capture) const = 0;

  /// Forgets all images, as if it were new, and works at an effort level from now on: 0 is what the settings ask for,
  /// `ModelSettings::effort_levels` - 1 the quickest. Snapshots count on.
  virtual void restart(int effort_level) = 0;
  /// The same, but for what the first image that showed something has decided, whether it comes again or not.
  virtual void rebuild(int effort_level) { restart(effort_level); }
  /// The finest effort level, `from` or a quicker one, whose model the memory can hold whatever images come (held-out
  /// views apart); the quickest where it can hold none.
  virtual int effort_level_within([[maybe_unused]] const Capture& first, int from,
                                  [[maybe_unused]] const MemoryLimit& limit) const {
    return from;
  }
  /// Lets go of detail, one step of a few, in all patches at once: frees memory. It holds from now on, until a restart.
  /// False when no step is left.
  virtual bool reduce_memory() { return false; }
  /// How much of what an image shows is updated, in (0, 1]: the parts that learn most from it. For the images to come.
  /// A model that always updates all of itself does nothing.
  virtual void set_update_fraction([[maybe_unused]] double fraction) {}

  virtual std::shared_ptr<const ModelSnapshot> snapshot() = 0;
  /// No image follows: lets go of what only more images would need. Snapshot and figures stay what they are.
  virtual void finish() {}
  /// After `finish`: the snapshot, which a large model no longer keeps; it is not asked for one again.
  virtual std::shared_ptr<const ModelSnapshot> give_snapshot() { return snapshot(); }
  /// The mean colour of each surface sample over all images: what a model without view dependence would be. Every
  /// figure stands beside it.
  virtual std::shared_ptr<const Appearance> constant_colour() const = 0;

  virtual const ModelSettings& settings() const = 0;  ///< with the limits of the effort level and of the memory on them
  virtual ModelFigures figures() const = 0;
  /// All but held-out views and probe; all images are taken to be as large as `image`.
  virtual MemoryAccount memory(const CaptureSize& image) const = 0;
};

}  // namespace sheen
