// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene_config.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "common/errors.h"
#include "reconstructor/evaluation/tradeoff.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

TEST(SceneConfig, AllKeysAreTaken) {
  const TempFolder folder;
  const auto& o = load_scene_config(folder.write("scene.toml", R"(
[surface_light_field]
surface_map = 12
max_rank = 5
internal_rank = 9
block = 4
tolerance = 0.02
max_views = 30
min_visible = 0.25
hold_out_every = 0
exposure = "estimate"
erosion_px = 3
)"))
                      .surface_light_field;
  EXPECT_EQ(o.surface_map, 12);
  EXPECT_EQ(o.ring.factor.max_rank, 5);
  EXPECT_EQ(o.ring.factor.internal_rank, 9);
  EXPECT_EQ(o.ring.factor.block, 4);
  EXPECT_EQ(o.ring.factor.tolerance, 0.02);
  EXPECT_EQ(o.ring.max_views, 30);
  EXPECT_EQ(o.ring.min_visible, 0.25);
  EXPECT_EQ(o.hold_out_every, 0);
  EXPECT_EQ(o.exposure, ExposureCompensation::kEstimate);
  EXPECT_EQ(o.visibility.erosion_px, 3);
}

TEST(SceneConfig, WhatIsWrittenIsReadAgain) {
  const TempFolder folder;
  SurfaceLightFieldOptions options{.surface_map = 12, .hold_out_every = 0};
  options.exposure = ExposureCompensation::kEstimate;
  options.ring.factor = {.max_rank = 5, .tolerance = 1.25e-7};
  options.ring.max_views = 30;
  options.ring.min_visible = 1;
  options.visibility.erosion_px = 3;
  const std::string text = to_toml(options);
  const auto o = load_scene_config(folder.write("scene.toml", text)).surface_light_field;
  EXPECT_EQ(to_toml(o), text);
  EXPECT_EQ(o.surface_map, 12);
  EXPECT_EQ(o.ring.factor.tolerance, 1.25e-7);
  EXPECT_EQ(o.exposure, ExposureCompensation::kEstimate);
  EXPECT_NE(to_toml({}), text);
}

TEST(SceneConfig, EverySettingOfASweepIsASceneFileOfItsOwn) {
  const TempFolder folder;
  std::set<std::string> texts;
  for (const Setting& setting : tradeoff_settings({}, false)) {
    const std::string text = to_toml(setting.options);
    const auto o = load_scene_config(folder.write("scene.toml", text)).surface_light_field;
    EXPECT_EQ(to_toml(o), text) << setting.name;
    EXPECT_NO_THROW(SurfaceLightField(std::make_shared<Mesh>(), o)) << setting.name;
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), tradeoff_settings({}, false).size()) << "what is swept has keys of its own";
}

TEST(SceneConfig, WhatIsNotSaidKeepsItsDefault) {
  const TempFolder folder;
  const SurfaceLightFieldOptions defaults;
  for (const char* text : {"", "# nothing\n", "[surface_light_field]\n"}) {
    const auto o = load_scene_config(folder.write("scene.toml", text)).surface_light_field;
    EXPECT_EQ(o.surface_map, defaults.surface_map);
    EXPECT_EQ(o.ring.factor.tolerance, defaults.ring.factor.tolerance);
    EXPECT_EQ(o.exposure, defaults.exposure);
  }
}

TEST(SceneConfig, AWholeNumberIsANumber) {
  const TempFolder folder;
  const auto o = load_scene_config(folder.write("s.toml", "[surface_light_field]\ntolerance = 0\nmin_visible = 1\n"));
  EXPECT_EQ(o.surface_light_field.ring.factor.tolerance, 0);
  EXPECT_EQ(o.surface_light_field.ring.min_visible, 1);
}

TEST(SceneConfig, ErrorsNameFileLineAndKey) {
  const TempFolder folder;
  const auto expect_refused = [&](const char* text, const std::vector<std::string>& words) {
    const auto file = folder.write("my scene.toml", text);
    expect_error<ConfigError>([&] { load_scene_config(file); }, words);
  };
  const std::string name = (folder.path() / "my scene.toml").string();
  expect_refused("[surface_light_field]\n\nmax_ranks = 3\n", {name + ":3", "unknown key max_ranks"});
  expect_refused("[surface_light_field]\nmax_rank = 3\n[surface_light_feild]\n", {name + ":3", "surface_light_feild"});
  expect_refused("max_rank = 3\n", {name + ":1", "max_rank"});
  expect_refused("[surface_light_field]\nmax_rank = 3.5\n", {name + ":2", "max_rank", "whole number"});
  expect_refused("[surface_light_field]\nmax_rank = \"3\"\n", {name + ":2", "max_rank", "whole number"});
  expect_refused("[surface_light_field]\nsurface_map = 4294967304\n", {name + ":2", "surface_map", "whole number"});
  expect_refused("[surface_light_field]\ntolerance = true\n", {name + ":2", "tolerance", "number"});
  expect_refused("[surface_light_field]\ntolerance = [0.1]\n", {name + ":2", "tolerance", "number"});
  expect_refused("[surface_light_field]\nexposure = \"auto\"\n", {name + ":2", "exposure", "estimate"});
  expect_refused("[surface_light_field]\nexposure = 1\n", {name + ":2", "exposure", "known"});
  expect_refused("[surface_light_field]\nmax_rank = 3\nmax_rank = 4\n", {name + ":3", "max_rank"});
  expect_refused("[surface_light_field]\nmax_rank =\n", {name + ":2"});
  expect_refused("surface_light_field = 1\n", {name + ":1", "surface_light_field"});
  expect_refused("[surface_light_field.deeper]\nx = 1\n", {name + ":1", "deeper"});
}

TEST(SceneConfig, AFileThatIsNotThereIsNamed) {
  const TempFolder folder;
  expect_error([&] { load_scene_config(folder.path() / "absent.toml"); }, {"absent.toml"});
}

}  // namespace
}  // namespace sheen
