// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/model_registry.h"

#include <array>

#include "reconstructor/models/intrinsic_lumigraph/kind.h"
#include "reconstructor/models/irradiance_field/kind.h"
#include "reconstructor/models/surface_light_field/kind.h"

namespace sheen {

std::span<const ModelKind* const> model_kinds() {
  static const std::array<const ModelKind*, 3> kinds{&surface_light_field_kind(), &irradiance_field_kind(),
                                                     &intrinsic_lumigraph_kind()};
  return kinds;
}

}  // namespace sheen
