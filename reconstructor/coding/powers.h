// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace sheen {

/// 2^(twelfths / 12), the same bits on every machine: by a table. What files hold in parts of an octave is read with
/// it.
inline double power_of_two(int twelfths) {
  constexpr double kTwelfths[] = {1.0,
                                  1.0594630943592953,
                                  1.122462048309373,
                                  1.189207115002721,
                                  1.2599210498948732,
                                  1.3348398541700344,
                                  1.4142135623730951,
                                  1.4983070768766815,
                                  1.5874010519681996,
                                  1.681792830507429,
                                  1.7817974362806785,
                                  1.887748625363387};
  const int octaves = (twelfths >= 0 ? twelfths : twelfths - 11) / 12;
  return std::ldexp(kTwelfths[twelfths - 12 * octaves], octaves);
}

}  // namespace sheen
