// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

/// Bytes that a light field of a mesh takes, from counts alone: told before hours are spent.
struct MemoryNeed {
  double least = 0;  ///< with the fewest terms that are any use, on the smallest maps
  double most = 0;   ///< with all terms and views that the options allow; maps no larger than the smallest
};
MemoryNeed memory_need(std::size_t vertices, std::size_t triangles, const SurfaceLightFieldOptions& options);

struct MachineMemory {
  double total = 0, available = 0;  ///< bytes; 0 where the system does not say
};
MachineMemory machine_memory();

/// What to say of a mesh on a machine: nothing where it fits; else the figures and what to do. Throws FileError naming
/// the mesh where even the least does not fit.
std::string memory_warning(const std::string& mesh_file, std::size_t vertices, std::size_t triangles,
                           const SurfaceLightFieldOptions& options, const MachineMemory& machine);

}  // namespace sheen
