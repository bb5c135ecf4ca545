// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/running_statistics.h"
#include "common/capture/capture.h"
#include "reconstructor/models/appearance_model.h"

namespace sheen {

/// What became of the captures so far.
struct FrameCounts {
  std::uint64_t received = 0, accepted = 0, held_out = 0;
  std::map<std::string, std::uint64_t> refused;  ///< by reason
  std::uint64_t withdrawn = 0;                   ///< taken back by the user
};

/// A capture that the reconstruction was given, and what became of it.
struct KnownCapture {
  std::string source_session;  ///< with `sequence`, of the capture
  std::uint64_t sequence = 0;
  IngestStatus status = IngestStatus::kRefused;
  std::string reason;     ///< of a refusal
  bool repeated = false;  ///< nothing of it was used: it shows what an earlier one does
  std::size_t patches_skipped = 0;
  bool response_known = false, vignette_known = false;  ///< what was measured of its camera
  float exposure_gain = 1;                        ///< that its values, or those of a held-out view, were divided by
  std::optional<Rigid3> camera_from_object = {};  ///< where it is not the one that its source has
};

/// Every capture and what became of it, and what the accepted images cost.
class CaptureAccount {
 public:
  /// What became of the patches that the accepted images showed.
  struct PatchCounts {
    std::uint64_t updated = 0, skipped = 0, left_out = 0;
  };

  /// Captures by what was measured of their camera.
  struct PhotometricCounts {
    std::uint64_t response = 0, vignette = 0, nothing = 0;
  };

  /// The captures come in other poses than their source has, which are to be known.
  void note_poses() { poses_noted_ = true; }
  void receive() { ++counts_.received; }
  /// A capture that was received, or one that is ingested again.
  void note(const Capture& capture, const IngestReport& report);
  /// Nothing where it is not known.
  const KnownCapture* find(const Capture& capture) const;
  /// Takes back one that `find` knows.
  void withdraw(const KnownCapture& known);
  /// Counts captures that were withdrawn and so do not arrive.
  void leave_out(std::uint64_t captures);
  /// Counts captures whose files cannot be read among the refused.
  void refuse_damaged(std::uint64_t captures);
  /// The accepted images are ingested again from the first.
  void forget_accepted();

  const FrameCounts& counts() const { return counts_; }
  const std::vector<KnownCapture>& captures() const { return captures_; }  ///< all that count
  const PatchCounts& patches() const { return patches_; }
  PhotometricCounts photometric() const;
  /// Seconds of each stage of an accepted image.
  const std::map<std::string, RunningStatistics>& stages() const { return stages_; }
  const RunningStatistics& updates() const { return updates_; }  ///< all stages of an image together
  double images_per_s() const;  ///< accepted images over the time spent on ingesting them

 private:
  FrameCounts counts_;
  std::vector<KnownCapture> captures_;
  std::map<std::string, RunningStatistics> stages_;
  RunningStatistics updates_;
  PatchCounts patches_;
  bool poses_noted_ = false;
};

}  // namespace sheen
