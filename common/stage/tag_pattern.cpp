// SPDX-License-Identifier: Apache-2.0
#include "common/stage/tag_pattern.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <memory>
#include <string>

#include "common/base/errors.h"

namespace sheen {

TagPattern tag_pattern(int id) {
  if (id < 0 || id >= kTagIdCount)
    throw ConfigError("tag id " + std::to_string(id) + " does not exist in tag36h11; use 0.." +
                      std::to_string(kTagIdCount - 1));
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  const std::uint64_t code = family->codes[id];
  TagPattern pattern;
  for (std::uint32_t bit = 0; bit < family->nbits; ++bit)  // the most significant bit stands first
    pattern.white[family->bit_y[bit]][family->bit_x[bit]] = (code >> (family->nbits - 1 - bit)) & 1;
  return pattern;
}

}  // namespace sheen
