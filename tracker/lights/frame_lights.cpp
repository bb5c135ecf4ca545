// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/frame_lights.h"

#include "tracker/lights/lamp_tag.h"
#include "tracker/lights/light_table.h"

namespace sheen {

std::string validation_error(const LightOptions& o) {
  if (o.tag.has_value() == !o.table.empty()) return "table or tag: give one of them";
  if (!o.tag) {
    if (o.index.empty() != o.first_frame.has_value())
      return "table needs index, a file with the entry of each frame, or first_frame, the number of the frame that its "
             "first entry lit";
    return {};
  }
  if (!o.index.empty() || o.first_frame) return "index and first_frame belong to a table";
  if (!(o.tag_size_m >= 0.001 && o.tag_size_m <= 10))
    return "tag_size_m must lie in 0.001..10: the black square's side";
  if (!(o.offset.cwiseAbs().maxCoeff() <= 100)) return "offset must be three numbers, metres, each 100 at most";
  return {};
}

std::unique_ptr<FrameLights> make_frame_lights(const LightOptions& options) {
  if (options.tag) return std::make_unique<LampTag>(options);
  return std::make_unique<LightTable>(options);
}

}  // namespace sheen
