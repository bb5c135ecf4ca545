// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/model_choice.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

constexpr Motion kStill = Motion::kStill, kMoves = Motion::kMoves;

TEST(ModelChoice, IsForWhatMoves) {
  const SceneRequest request("", "auto");
  ASSERT_TRUE(request.automatic());
  const auto chosen = [&](Motion camera, Motion light) {
    return std::string(request.chosen_by({camera, light}).kind->name());
  };
  EXPECT_EQ(chosen(kMoves, kStill), "surface_light_field");
  EXPECT_EQ(chosen(kStill, kMoves), "irradiance_field");
  EXPECT_EQ(chosen(kMoves, kMoves), "intrinsic_lumigraph");
  EXPECT_EQ(chosen(kStill, kStill), "surface_light_field");
}

TEST(ModelChoice, AFileMaySpeakOfAllModels) {
  const TempFolder temp;
  const std::string file = temp.write("s.toml",
                                      "model = \"auto\"\n[images]\nhold_out_every = 5\n[surface_light_field]\n"
                                      "max_rank = 7\n[irradiance_field]\n");
  const SceneRequest request(file, "");
  ASSERT_TRUE(request.automatic());
  EXPECT_EQ(request.chosen_by({kStill, kMoves}).settings->hold_out_every, 5);
  const SceneConfig scene = request.chosen_by({kMoves, kStill});
  for (const SettingKey& key : scene.settings->keys())
    if (key.name == "max_rank") EXPECT_EQ(std::get<std::int64_t>(key.get()), 7);

  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const std::string wrong = temp.write("wrong.toml", text);
    expect_error<ConfigError>([&] { SceneRequest(wrong, ""); }, words);
  };
  refused("model = \"auto\"\n[surface_light_field]\nmax_ranks = 7\n", {"wrong.toml:3", "max_ranks"});
  refused("model = \"auto\"\n[hologram]\n", {"wrong.toml:2", "hologram"});
  refused("model = \"auto\"\n[[effort_level]]\nimage_ms = 3\npsnr_db = 30\n", {"wrong.toml:2", "of one model"});
  expect_error<ConfigError>([&] { load_scene_config(file); }, {"s.toml:1", "only `build` and `serve` choose it"});
  EXPECT_FALSE(SceneRequest("", "").automatic());
  EXPECT_STREQ(SceneRequest("", "irradiance-field").named().kind->name(), "irradiance_field");
  expect_error<ConfigError>([] { SceneRequest("", "hologram"); }, {"--model must be one of", "\"auto\""});
}

TEST(ModelChoice, WarnsOfWhatMovesAlthoughItIsTakenToStandStill) {
  const SceneConfig field = SceneRequest("", "irradiance-field").named(), surface = default_scene(),
                    lumigraph = SceneRequest("", "intrinsic-lumigraph").named();
  EXPECT_EQ(motion_warning(*field.kind, {kStill, kMoves}), "");
  EXPECT_EQ(motion_warning(*surface.kind, {kMoves, kStill}), "");
  EXPECT_EQ(motion_warning(*lumigraph.kind, {kMoves, kMoves}), "");
  EXPECT_EQ(motion_warning(*lumigraph.kind, {kStill, kStill}), "") << "it may still begin to move";
  EXPECT_NE(motion_warning(*field.kind, {kMoves, kMoves}).find("the camera moves"), std::string::npos);
  EXPECT_NE(motion_warning(*surface.kind, {kMoves, kMoves}).find("the light moves"), std::string::npos);
}

}  // namespace
}  // namespace sheen
