// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "common/capture/capture.h"

namespace sheen {

/// What a reconstruction holds, in bytes per part. A function of mesh, settings and captures.
struct MemoryAccount {
  static constexpr double kProgram = 45e6;  ///< with its libraries, before an image comes (measured)
  /// Of the model: what is not counted of it and what the allocator adds (measured: up to 0.15, and 0.4 of a model
  /// of 34 MB). Two snapshots have patches in common, which makes up for it.
  static constexpr double kPieces = 0.25;

  double mesh = 0;
  double ray_scene = 0;  ///< what rays are cast at, to find what images show and to paint
  double ingest = 0;     ///< what an image is ingested with: its samples and pixels, and the samples' mean colours
  double model = 0;      ///< what has been learned
  double snapshots = 0;  ///< two: the one that is shown, and the one that follows
  double held_out = 0;   ///< views that judge
  double probe = 0;      ///< images that a budget's effort level is chosen by, until it is

  bool shown = true;  ///< there are snapshots before the end

  /// Nothing is shown before the end. Then the finished model takes the place of what was learned: `snapshots` is how
  /// much larger it is.
  MemoryAccount unshown() const;
  double overhead() const { return kProgram + (shown && snapshots > 0 ? 0 : kPieces * (model + snapshots)); }
  double total() const { return mesh + ray_scene + ingest + model + snapshots + held_out + probe + overhead(); }
  std::map<std::string, double> parts() const;
};

struct CaptureSize {
  double pixels = 0, bytes = 0;
  bool lens_bends = false;
};
CaptureSize size_of(const Capture& capture);

/// What a model has to keep within.
struct MemoryLimit {
  double bytes = 0;
  std::size_t images = 0;  ///< at most that will come
  bool shown = true;       ///< snapshots are taken while it grows
};

/// Bytes that a model of a mesh takes, from counts alone: to be said before hours are spent.
struct MemoryNeed {
  double least = 0;  ///< with the least detail that is any use
  double most = 0;   ///< with all that the settings allow
};

}  // namespace sheen
