// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/resident_memory.h"

#include <fstream>
#include <string>

namespace sheen {

ResidentMemory resident_memory() {
  ResidentMemory memory;
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(1 << 10, '\n')) {
    double kilobytes = 0;
    if (key == "VmRSS:" && status >> kilobytes) memory.bytes = 1024 * kilobytes;
    if (key == "VmHWM:" && status >> kilobytes) memory.peak_bytes = 1024 * kilobytes;
  }
  return memory;
}

}  // namespace sheen
