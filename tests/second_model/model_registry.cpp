// SPDX-License-Identifier: Apache-2.0
// The registry of a program that knows one model more: sheen-reconstructor with nothing else changed.
#include "reconstructor/models/model_registry.h"

#include <array>

#include "reconstructor/models/surface_light_field/kind.h"
#include "tests/second_model/flat_colour.h"

namespace sheen {

std::span<const ModelKind* const> model_kinds() {
  static const std::array<const ModelKind*, 2> kinds{&surface_light_field_kind(), &testing::flat_colour_kind()};
  return kinds;
}

}  // namespace sheen
