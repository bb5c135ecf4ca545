// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// Of this process, as the operating system has it; 0 where it does not say.
struct ResidentMemory {
  double bytes = 0, peak_bytes = 0;
};
ResidentMemory resident_memory();

}  // namespace sheen
