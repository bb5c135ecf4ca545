// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/vertex_views.h"

namespace sheen {

void VertexViews::believe_reflection() {
  if (!reflection) return;
  const Eigen::VectorXf drift = reflection->at_each(directions, frame.row(2));
  const ViewKriging kriging(directions, reliability, kernel, drift);
  believed = kriging.has_drift() ? kriging.believed_drift() : BelievedDrift{.mean = drift.mean()};
}

}  // namespace sheen
