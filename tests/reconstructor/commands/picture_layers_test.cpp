// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/picture_layers.h"

#include <gtest/gtest.h>

#include "tests/support/expect_error.h"
#include "tests/support/lit_object.h"

namespace sheen {
namespace {

TEST(PictureLayers, AnIrradianceFieldHasNone) {
  const std::vector<LightState> lights{{LightKind::kDirectional, {0, 0.6, 0.8}},
                                       {LightKind::kDirectional, {0.6, 0, 0.8}}};
  const auto field = LitObject::make(24, 18).field(lights);
  const auto refusal = [&](const char* layer) { return [&, layer] { PictureLayers({layer}, field, "scene.rif"); }; };
  expect_error<ConfigError>(refusal("depth"), {"scene.rif has no layer depth", "knows of no surface"});
  expect_error<ConfigError>(refusal("normals"), {"scene.rif has no layer normals"});
  expect_error<ConfigError>(refusal("shadow"), {"scene.rif has no layer shadow", "only an intrinsic lumigraph"});
}

}  // namespace
}  // namespace sheen
