// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {

/// What a reconstruction holds, in bytes, a part each. A function of mesh, options and captures.
struct MemoryAccount {
  double mesh = 0;
  double ray_scene = 0;  ///< what rays are cast at, once to find what images show and once to paint
  double ingest = 0;     ///< what an image is taken in with: its samples and pixels, and the samples' mean colours
  double rings = 0;      ///< the model
  double snapshots = 0;  ///< two: the one that is shown, and the one that follows
  double held_out = 0;   ///< views that judge
  double probe = 0;      ///< images that a budget's rung is chosen by, until it is

  double total() const { return mesh + ray_scene + ingest + rings + snapshots + held_out + probe; }
  std::map<std::string, double> parts() const;
};

struct CaptureSize {
  double pixels = 0, bytes = 0;
};
CaptureSize size_of(const Capture& capture);
/// Mesh, ray scene and ingest; the rest 0. All images are taken to be as large.
MemoryAccount fixed_account(const Mesh& mesh, const VertexRings& rings, const CaptureSize& image);
/// Upper bound of all but held-out views and probe once every ring holds all the terms and views that the options
/// allow.
MemoryAccount largest_account(const Mesh& mesh, const Capture& first, const SurfaceLightFieldOptions& options);

/// Of this process, as the operating system has it; 0 where it does not say.
struct ResidentMemory {
  double bytes = 0, peak_bytes = 0;
};
ResidentMemory resident_memory();

}  // namespace sheen
