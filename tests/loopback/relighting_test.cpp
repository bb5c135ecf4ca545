// SPDX-License-Identifier: Apache-2.0
// Light that moves, as a user has it: a list of lights is built, scored, rendered, compressed and drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/loopback/lit_ball.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Relighting : public ::testing::Test {
 protected:
  Relighting() {
    LitBall{.folder = temp_.path() / "train"}.write();
    LitBall{.folder = temp_.path() / "test", .lights = 5, .turn = 0.4}.write();
  }
  Outcome build(const Words& more) const {
    return run_to_end(reconstructor({"build", train_, "--model", "irradiance-field"}) + more);
  }

  const TempFolder temp_;
  const fs::path train_ = temp_.path() / "train/dirs.lp", test_ = temp_.path() / "test/dirs.lp",
                 model_ = temp_.path() / "field.rif";
};

TEST_F(Relighting, AListIsBuiltScoredAndRendered) {
  const fs::path report = temp_.path() / "build.json", scores = temp_.path() / "scores.json",
                 out = temp_.path() / "out";
  expect_outcome(build({"--out", model_, "--bytes", "20kB", "--json", report}), 0, {"24 images added to the model"});
  EXPECT_LE(fs::file_size(model_), 20000u);
  const Json built = Json::parse(read_file(report));
  EXPECT_EQ(built["settings"]["model"], "irradiance_field");
  EXPECT_GT(built["bytes_per_patch"], 0);
  EXPECT_EQ(built["frames"]["accepted"], 24);
  EXPECT_EQ(built["file"]["bytes"], fs::file_size(model_));

  expect_outcome(run_to_end(reconstructor({"evaluate", model_, test_, "--json", scores})), 0,
                 {"light4.png", "mean over 5 lights"});
  const Json scored = Json::parse(read_file(scores));
  EXPECT_EQ(scored["views"].size(), 5u);
  EXPECT_GT(scored["object"]["psnr_db"], 40);
  EXPECT_GT(scored["object"]["psnr_db"].get<double>(), scored["constant"]["psnr_db"].get<double>() + 10);

  const fs::path list = temp_.path() / "pictures.json";
  expect_outcome(run_to_end(reconstructor({"render", model_, "--lights", test_, "--out", out, "--json", list})), 0,
                 {"5 pictures rendered"});
  EXPECT_EQ(Json::parse(read_file(list))["pictures"][3]["file"], "light3");
  const ImageU8 picture = to_srgb8(to_linear_rgb(read_image(out / "light3.png"))),
                truth = to_srgb8(to_linear_rgb(read_image(temp_.path() / "test/light3.png")));
  ASSERT_EQ(picture.size(), truth.size());
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) squares += std::pow(picture.data()[i] - truth.data()[i], 2);
  const double db = 10 * std::log10(255 * 255 * static_cast<double>(truth.size()) / squares);
  EXPECT_NEAR(db, scored["views"][3]["psnr_db"].get<double>(), 1e-6) << "what is scored is what is rendered";
  EXPECT_TRUE(fs::exists(out / "light3.exr"));
}

TEST_F(Relighting, LampsAddUp) {
  expect_outcome(build({"--out", model_, "--bytes", "40kB"}), 0, {});
  const fs::path out = temp_.path() / "out";
  // Light from all around is as the lamps' own: of radiance 1.
  ImageF map(32, 16, 3);
  std::fill_n(map.data(), map.size(), 1.0f);
  write_exr(temp_.path() / "sky.exr", map);
  expect_outcome(run_to_end(reconstructor({"render", model_, "--environment", temp_.path() / "sky.exr", "--out", out})),
                 0, {"of its light comes from where the model's images had none", "1 pictures rendered"});
  EXPECT_TRUE(fs::exists(out / "sky.exr"));
  const fs::path lamps = temp_.write("lamps.json", R"({"format": "sheen luminaires", "version": 1, "pictures": [
      {"name": "red", "lights": [{"towards": [0, 0.3, 1], "rgb": [1, 0.001, 0.001]}]},
      {"name": "blue", "lights": [{"towards": [0.5, 0, 1], "rgb": [0.001, 0.001, 1]}]},
      {"name": "both", "lights": [{"towards": [0, 0.3, 1], "rgb": [1, 0.001, 0.001]},
                                  {"towards": [0.5, 0, 1], "rgb": [0.001, 0.001, 1]}]},
      {"name": "panel", "lights": [{"area": {"centre": [0, 0, 2], "half_u": [0, 0.5, 0], "half_v": [0.5, 0, 0]}},
                                   {"environment": "sky.exr", "rgb": [0.1, 0.1, 0.1]}]}]})");
  expect_outcome(run_to_end(reconstructor({"render", model_, "--luminaires", lamps, "--out", out})), 0,
                 {"4 pictures rendered"});
  const auto radiance = [&](const char* name) { return read_exr(out / name).parts.front().image; };
  const ImageF red = radiance("red.exr"), blue = radiance("blue.exr"), both = radiance("both.exr");
  for (std::size_t i = 0; i < both.size(); i += 97)
    EXPECT_NEAR(both.data()[i], red.data()[i] + blue.data()[i], 2e-3f * (1 + both.data()[i])) << i;
  expect_outcome(run_to_end(reconstructor({"render", model_, "--light-path", test_, "--frames", "7", "--out", out})), 0,
                 {"7 pictures rendered"});
  EXPECT_TRUE(fs::exists(out / "frame_00007.png"));
  for (const auto& [lights, message] :
       {std::pair{R"([])", "pictures[0].lights"},
        {R"([{"towards": [0, 0, 0]}])", "must not be 0 0 0"},
        {R"([{"glow": 1}])", "must have one of at, towards, area, environment"},
        {R"([{"area": {"centre": [0, 0, 2], "half_u": [0.5, 0, 0], "half_v": [0, 0.5, 0]}}])", "away from the object"},
        {R"([{"environment": "night.exr"}])", "night.exr"}}) {
    const fs::path wrong = temp_.write("wrong.json", R"({"format": "sheen luminaires", "version": 1, "pictures": [
        {"name": "a", "lights": )" + std::string(lights) +
                                                         "}]}");
    expect_outcome(run_to_end(reconstructor({"render", model_, "--luminaires", wrong, "--out", out})), 1, {message});
  }
  expect_outcome(run_to_end(reconstructor(
                     {"render", model_, "--lights", test_, "--environment", temp_.path() / "sky.exr", "--out", out})),
                 2, {"--environment"});
}

TEST_F(Relighting, SaysWhichLightsAreTooFarApart) {
  const fs::path report = temp_.path() / "lights.json";
  expect_outcome(build({"--out", model_, "--bytes", "40kB", "--tolerance", "16", "--json", report}), 0,
                 {"intervals between lights are too wide", "the next light is worth most at"});
  const Json lights = Json::parse(read_file(report))["lights"];
  EXPECT_EQ(lights["tolerance_grey_levels"], 16);
  EXPECT_GE(lights["intervals"], 24);
  EXPECT_EQ(lights["next_light"].size(), 3u);
  expect_outcome(build({"--out", model_, "--tolerance", "40dB"}), 2, {"--tolerance", "grey levels"});
}

TEST_F(Relighting, IsExportedForOtherPrograms) {
  expect_outcome(build({"--out", model_, "--bytes", "40kB"}), 0, {});
  const fs::path ptm = temp_.path() / "ball.ptm", web = temp_.path() / "web", report = temp_.path() / "export.json";
  expect_outcome(run_to_end(reconstructor({"export", model_, "--relight", ptm, "--json", report})), 0,
                 {"the model's 24 lights with"});
  EXPECT_EQ(Json::parse(read_file(report))["relight"]["lights"], 24);
  EXPECT_GT(Json::parse(read_file(report))["relight"]["psnr_db"], 20);
  EXPECT_TRUE(read_file(ptm).starts_with("PTM_1.2\nPTM_FORMAT_RGB\n60\n44\n"));
  expect_outcome(run_to_end(reconstructor({"export", model_, "--relight", web})), 0, {"the model's 24 lights with"});
  EXPECT_TRUE(fs::exists(web / "info.json") && fs::exists(web / "plane_5.jpg"));
}

TEST_F(Relighting, AFolderIsCompressedLater) {
  const fs::path folder = temp_.path() / "model";
  expect_outcome(build({"--out", folder, "--loss", "0dB"}), 0, {"24 images added to the model"});
  expect_outcome(run_to_end(reconstructor({"compress", folder, "--out", model_, "--bytes", "20kB"})), 0, {});
  EXPECT_LE(fs::file_size(model_), 20000u);
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, test_})), 0, {"mean over 5 lights"});
}

TEST_F(Relighting, IsDrawnInTheLightOfTheMouse) {
  expect_outcome(build({"--out", model_, "--bytes", "20kB"}), 0, {});
  const fs::path picture = temp_.path() / "window.png";
  const Outcome outcome = run_to_end(Words{SHEEN_WITH_XVFB} + reconstructor({"view", model_, "--screenshot", picture,
                                                                             "--clean", "--size", "240x176"}));
  if (outcome.output.find("without a display") != std::string::npos) GTEST_SKIP() << "no Xvfb here";
  expect_outcome(outcome, 0, {});
  const ImageU8 shown = to_srgb8(to_linear_rgb(read_image(picture)));
  const auto* middle = shown.pixel(120, 88);
  EXPECT_GT(middle[2], middle[1]);
  EXPECT_GT(middle[1], middle[0] + 20) << "the ball's colour";
}

TEST_F(Relighting, WrongUseIsTold) {
  expect_outcome(run_to_end(reconstructor({"build", train_, "--out", model_})), 2,
                 {"--mesh is required", "irradiance-field"});
  expect_outcome(build({"--out", model_, "--mesh", "x.ply"}), 2, {"--mesh", "makes its own surface"});
  expect_outcome(run_to_end(reconstructor({"build", train_, "--model", "hologram"})), 2,
                 {"--model must be one of", "\"irradiance_field\"", "not hologram"});
  expect_outcome(build({"--out", model_, "--bytes", "20kB"}), 0, {});
  expect_outcome(run_to_end(reconstructor({"render", model_, "--out", temp_.path() / "out"})), 2,
                 {"--cameras is required"});
  const fs::path positions = temp_.write("near.lp", "1\na.png 0 0 3\n");
  expect_outcome(run_to_end(reconstructor({"render", model_, "--lights", positions, "--out", temp_.path() / "out"})), 2,
                 {"positions of near lights", "built from directions"});
  std::string damaged = read_file(model_);
  damaged[damaged.size() / 2] ^= 1;
  const fs::path broken = temp_.write("broken.rif", damaged);
  expect_outcome(run_to_end(reconstructor({"render", broken, "--lights", test_, "--out", temp_.path() / "out"})), 1,
                 {"broken.rif", "is damaged"});
}

TEST_F(Relighting, PlansForASurfaceOfAFile) {
  const auto plan = [&](const std::string& brdf) {
    const fs::path report = temp_.path() / "file_plan.json";
    expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "1", "--brdf", brdf, "--json", report})), 0,
                   {"80 degrees"});
    return Json::parse(read_file(report));
  };
  const std::string head = R"({"format": "sheen brdf", "version": 1, )";
  // Lafortune's mirror lobe has |w| = 1: as a free lobe.
  const fs::path parts = temp_.write("parts.json", head + R"("parts": [{"lafortune": [-1, -1, 1], "exponent": 20}]})");
  EXPECT_NEAR(plan(parts)["spacing_on_grid_m"], std::sqrt(4 * 16 / 255.0 / 23), 0.01 * 0.104);
  const fs::path table = temp_.write("table.json", head + R"("table": {"coordinates": "light_eye", "angles_deg":
      [[0, 90], [0, 90], [0, 180]], "values": [2, 2, 2, 2, 2, 2, 2, 2]}})");
  EXPECT_NEAR(plan(table)["spacing_on_grid_m"], std::sqrt(4 * 16 / 255.0 / 3), 0.01 * 0.289);
  for (const auto& [text, message] :
       {std::pair{R"("parts": []})", "\"parts\""},
        {R"("parts": [{"lafortune": [-1, -1, 1], "exponent": 1.5}]})", "exponent must be 0, 1 or 2"},
        {R"("parts": [{"ggx": 2, "roughness": 0.3}]})", "parts[0].ggx"},
        {R"("table": {"coordinates": "polar"}})", "table.coordinates"},
        {R"("table": {"coordinates": "light_eye", "angles_deg": [[0, 90], [0, 90], [0, 180]],
            "values": [1, 1, 1, 1, 1, 1, 1, 1, 1]}})",
         "one value for each crossing"},
        {"\"parts\"", "is not JSON"}}) {
    const fs::path file = temp_.write("broken.json", head + text);
    expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "1", "--brdf", file})), 1,
                   {"broken.json", message});
  }
}

/// A table in the form of the MERL database: of a matt surface.
TEST_F(Relighting, PlansForAMeasuredTable) {
  const std::int32_t counts[] = {90, 90, 180};
  std::vector<double> values(3 * 90 * 90 * 180, 700);
  std::string bytes(reinterpret_cast<const char*>(counts), sizeof counts);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  const fs::path file = temp_.write("matt.binary", bytes), report = temp_.path() / "merl_plan.json";
  expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "1", "--brdf", file, "--json", report})), 0,
                 {"lights on a grid"});
  EXPECT_NEAR(Json::parse(read_file(report))["spacing_on_grid_m"], std::sqrt(4 * 16 / 255.0 / 3), 0.01 * 0.289);
  bytes.pop_back();
  expect_outcome(
      run_to_end(reconstructor({"plan-lights", "--distance", "1", "--brdf", temp_.write("m.binary", bytes)})), 1,
      {"m.binary", "90 x 90 x 180"});
}

TEST_F(Relighting, OtherModelsHaveOneLight) {
  const BallDataset data{.folder = temp_.path() / "ball", .views = 6};
  data.write();
  const fs::path model = temp_.path() / "model";
  expect_outcome(run_to_end(reconstructor({"build", data.folder, "--mesh", data.mesh(), "--out", model})), 0, {});
  expect_outcome(run_to_end(reconstructor({"render", model, "--lights", test_, "--out", temp_.path() / "out"})), 2,
                 {"one fixed light"});
  expect_outcome(run_to_end(reconstructor({"evaluate", model, test_})), 2, {"one fixed light"});
}

TEST(PlanLights, SaysTheSpacingAndWhatItDoesNotCover) {
  const TempFolder temp;
  const fs::path report = temp.path() / "plan.json";
  expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "2", "--tolerance", "16", "--json", report})),
                 0, {"lights on a grid", "cast shadows", "horizon"});
  const Json plan = Json::parse(read_file(report));
  EXPECT_DOUBLE_EQ(plan["spacing_on_grid_m"], 2 * std::sqrt(4 * 16 / 255.0 / 3));
  expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "2", "--brdf", "lafortune:2:0,1:20"})), 0, {});
  EXPECT_NEAR(plan["searched_curvature"], 3, 0.06) << "the search over normals agrees with the closed form";
  EXPECT_DOUBLE_EQ(plan["far_spacing_on_grid_deg"], 180 / std::acos(-1) * std::sqrt(4 * 16 / 255.0));
  for (const char* brdf : {"mirror", "lafortune:", "lafortune:0.5", "lafortune:-1:2", "lafortune:1:2,"})
    expect_outcome(run_to_end(reconstructor({"plan-lights", "--distance", "2", "--brdf", brdf})), 2, {"--brdf takes"});
}

}  // namespace
}  // namespace sheen::testing
