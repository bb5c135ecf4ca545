// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "reconstructor/models/memory_account.h"

namespace sheen {

struct MachineMemory {
  double total = 0, available = 0;  ///< bytes; 0 where the system does not say
};
MachineMemory machine_memory();

/// What to say of a mesh on a machine: nothing where it fits; else the figures and what to do. Throws FileError naming
/// the mesh where even the least does not fit.
std::string memory_warning(const std::string& mesh_file, std::size_t triangles, const MemoryNeed& need,
                           const MachineMemory& machine);

}  // namespace sheen
