// SPDX-License-Identifier: Apache-2.0
// `tradeoff` and `figures` as a user has them, on a tiny data set.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;

TEST(Tradeoff, MeasuresPlotsAndChooses) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data"};
  data.write();
  const fs::path out = temp.path() / "out", report = temp.path() / "report.json";
  expect_outcome(run_to_end(reconstructor({"tradeoff", data.folder, "--mesh", data.mesh(), "--config", data.scene(),
                                           "--quick", "--out", out, "--json", report, "--memory", "1GB"})),
                 0, {"PSNR dB", "default", "at most 1000 MB", "[surface_light_field]"});
  for (const char* file : {"tradeoff_time.csv", "tradeoff_bytes.csv", "tradeoff_time.svg"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  const auto json = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(json["training_images"], 14);
  EXPECT_EQ(json["held_out_views"], 2);
  EXPECT_GT(json["points"].size(), 10u);
  ASSERT_EQ(json["patches"].size(), 5u) << "1, 2, 4, 8 and 16 triangles";
  for (const auto& patch : json["patches"]) {
    EXPECT_GT(patch["psnr_db"].get<double>(), 15);
    EXPECT_GT(patch["seam"].get<double>(), 0);
  }
  int best = 0;
  for (const auto& point : json["points"]) {
    EXPECT_GT(point["psnr_db"].get<double>(), 15);
    EXPECT_GT(point["bytes"].get<double>(), 0);
    best += point["psnr_db"] > json["choice"]["psnr_db"];
  }
  EXPECT_EQ(best, 0) << "with memory to spare the best one is chosen";
  EXPECT_TRUE(json["choice"]["holds"]);

  // What it writes is a scene file whose effort levels --budget and --target go by.
  const auto level = [&](std::size_t r) { return json["points"][json["points"].size() - 6 + r]; };
  EXPECT_EQ(level(1)["part"], "effort level");
  const std::string target = std::to_string(level(5)["psnr_db"].get<double>() - 0.01) + "dB";
  const SecureLink link(temp.path());
  Process desk(serve(data.mesh(), temp.path() / "session",
                     link.reconstructor_options() + Words{"--once", "--config", out / "scene.toml", "--target", target,
                                                          "--json", temp.path() / "desk.json"}));
  expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data.folder.string()}) + link.tracker_options()), 0,
                 {});
  expect_outcome(wait_to_end(desk), 0, {"14 images added to the model"});
  const auto served = nlohmann::json::parse(read_file(temp.path() / "desk.json"));
  EXPECT_EQ(served["settings"]["effort_level"], 5);
  EXPECT_EQ(served["held_out"]["psnr_db"], level(5)["psnr_db"]) << "the very model that was measured";
  EXPECT_TRUE(served["settings"]["target"]["reached"]);

  // What it prints is a scene file.
  const fs::path scene = temp.write("chosen.toml", json["choice"]["scene"].get<std::string>());
  expect_outcome(run_to_end(reconstructor({"build", data.folder, "--mesh", data.mesh(), "--config", scene})), 0,
                 {"14 images added to the model"});
}

TEST(Tradeoff, CtrlCEndsItSoonAndKeepsWhatWasMeasured) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data", .views = 40, .width = 320, .height = 240};
  data.write();
  const fs::path report = temp.path() / "report.json";
  Process study(reconstructor({"tradeoff", data.folder, "--mesh", data.mesh(), "--json", report}));
  ASSERT_TRUE(study.prints("triangles", kPatience)) << study.output();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  study.signal(SIGINT);
  const auto end = study.wait(std::chrono::seconds(5));
  ASSERT_TRUE(end) << "still measures after Ctrl-C";
  expect_outcome({*end, study.output()}, 1, {"stopped"});
  if (fs::exists(report)) EXPECT_FALSE(nlohmann::json::parse(read_file(report))["points"].empty());
}

TEST(Tradeoff, RefusesWordsItDoesNotKnow) {
  expect_outcome(run_to_end(reconstructor({"tradeoff", "nowhere", "--mesh", "none.ply", "--budget", "33"})), 2,
                 {"--budget 33", "33ms"});
}

TEST(Target, BuildTakesTheCheapestSettingThatReachesIt) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data"};
  data.write();
  const auto build = [&](const std::string& target, const std::vector<std::string>& words) {
    const fs::path report = temp.path() / "report.json";
    expect_outcome(run_to_end(reconstructor({"build", data.folder, "--mesh", data.mesh(), "--config", data.scene(),
                                             "--target", target, "--json", report})),
                   0, words);
    return nlohmann::json::parse(read_file(report));
  };
  const auto easy = build("15dB", {"effort level 5", "14 images added to the model"});
  EXPECT_TRUE(easy["settings"]["target"]["reached"]);
  EXPECT_EQ(easy["settings"]["map_scale"], 0.4);
  const auto impossible = build("99dB", {"effort level 0", "no setting within the limits reaches 99.00 dB"});
  EXPECT_FALSE(impossible["settings"]["target"]["reached"]);
  EXPECT_GE(impossible["held_out"]["psnr_db"], easy["held_out"]["psnr_db"]);
}

TEST(Target, NeedsViewsToJudgeBy) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data", .views = 4};  // none of them is a test view
  data.write();
  expect_outcome(run_to_end(reconstructor(
                     {"build", data.folder, "--mesh", data.mesh(), "--config", data.scene(), "--target", "30dB"})),
                 2, {"--target", "--hold-out"});
}

TEST(Figures, WritesPageTablesAndPictures) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data", .views = 24};
  data.write();
  const fs::path out = temp.path() / "out";
  expect_outcome(run_to_end(reconstructor(
                     {"figures", data.folder, "--mesh", data.mesh(), "--out", out, "--quick", "--only", "4,5,8,9"})),
                 0, {"figure 4", "figure 5", "figure 8", "figure 9"});
  const std::string page = read_file(out / "paper_results.md");
  for (const char* text : {"## Figure 5", "## Figure 9", "33.2 dB", "67"})
    EXPECT_NE(page.find(text), page.npos) << text;
  for (const char* file : {"figure_08_online_and_batch.svg", "figure_09_time.csv", "figure_05_imputation_on.png"})
    EXPECT_TRUE(fs::exists(out / "images" / file)) << file;
}

TEST(Figures, AMeshBelongsToItsDataSet) {
  const TempFolder temp;
  expect_outcome(run_to_end(reconstructor({"figures", "--mesh", "ball.ply", "--out", temp.path()})), 2, {"--mesh"});
}

}  // namespace
}  // namespace sheen::testing
