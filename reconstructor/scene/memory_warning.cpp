// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/memory_warning.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "common/base/errors.h"
#include "common/base/quantity.h"

namespace sheen {
MachineMemory machine_memory() {
  MachineMemory memory;
  std::ifstream in("/proc/meminfo");
  std::string name, unit;
  for (double kilobytes = 0; in >> name >> kilobytes; std::getline(in, unit)) {
    if (name == "MemTotal:") memory.total = 1024 * kilobytes;
    if (name == "MemAvailable:") memory.available = 1024 * kilobytes;
  }
  return memory;
}

std::string memory_warning(const std::string& mesh_file, std::size_t triangles, const MemoryNeed& need,
                           const MachineMemory& machine) {
  if (machine.total <= 0 || need.most <= machine.available) return {};
  const double triangle_bytes = need.most / static_cast<double>(triangles);
  const double fitting = std::floor(machine.available / triangle_bytes / 1000) * 1000;
  const std::string text = std::to_string(triangles) + " triangles: the model takes " + gigabytes(need.least) + " to " +
                           gigabytes(need.most) + " of memory, this machine has " + gigabytes(machine.total) + ", " +
                           gigabytes(machine.available) + " of them free; simplify the mesh to " +
                           std::to_string(static_cast<long long>(fitting)) + " triangles";
  if (need.least > machine.total) throw FileError(mesh_file, text);
  return mesh_file + ": " + text + ", or bound the model with --memory";
}

}  // namespace sheen
