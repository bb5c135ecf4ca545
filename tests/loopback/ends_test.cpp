// SPDX-License-Identifier: Apache-2.0
// How a capture ends: the first signal finishes the model, the second leaves everything for later.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "reconstructor/monitor/monitor_client.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;
using Json = nlohmann::json;

constexpr std::chrono::seconds kStopPatience{5};  ///< a second is asked for; machines that run tests are slow

class Ends : public ::testing::Test {
 protected:
  explicit Ends(int views = 16) : data_{.folder = temp_.path() / "data", .views = views} { data_.write(); }

  /// A daemon that has ingested every view, and whose tracker is done.
  std::unique_ptr<Process> captured(const Words& launcher = {}) {
    const std::string address = free_address();
    auto desk =
        std::make_unique<Process>(launcher + serve(data_.mesh(), session_, {"--endpoint", address, "--json", report_}));
    expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                   {std::to_string(data_.views) + " keyframes sent"});
    return desk;
  }
  void expect_finished(Process& desk) {
    expect_outcome(wait_to_end(desk), 0,
                   {"finishing", "the model is saved", model_.string(), "images added to the model"});
    const Json frames = Json::parse(read_file(report_))["frames"];
    EXPECT_EQ(frames["received"], data_.views);
    EXPECT_EQ(frames["waiting"], 0);
    EXPECT_EQ(frames["lost"], 0);
    EXPECT_EQ(frames["accepted"].get<int>() + frames["held_out"].get<int>(), data_.views);
    expect_outcome(run_to_end(reconstructor(
                       {"build", session_, "--mesh", data_.mesh(), "--out", temp_.path() / "built", "--loss", "0dB"})),
                   0, {});
    expect_same_model(model_, temp_.path() / "built");
  }

  const TempFolder temp_;
  const BallDataset data_;
  const std::filesystem::path session_ = temp_.path() / "session", model_ = session_ / "model",
                              report_ = temp_.path() / "report.json";
};

class EndsBySignal : public Ends, public ::testing::WithParamInterface<int> {};

TEST_P(EndsBySignal, ModelAndReportAreFinished) {
  const auto desk = captured();
  desk->signal(GetParam());
  expect_finished(*desk);
}
INSTANTIATE_TEST_SUITE_P(Signals, EndsBySignal, ::testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST_F(Ends, UnderNohupATerminalThatGoesAwayEndsNothing) {
  const auto desk = captured({"nohup"});
  desk->signal(SIGHUP);
  EXPECT_FALSE(desk->wait(milliseconds(500))) << desk->output();
  EXPECT_THAT(desk->output(), ::testing::Not(::testing::HasSubstr("finishing")));
  desk->signal(SIGTERM);
  expect_finished(*desk);
}

TEST_F(Ends, WhoReadsTheMessagesMayBeGone) {
  const std::string address = free_address();
  std::string command;
  for (const std::string& word : serve(data_.mesh(), session_, {"--endpoint", address, "--once", "--json", report_}))
    command += "'" + word + "' ";
  Process desk({"bash", "-c", "set -o pipefail; " + command + "2>&1 | head -c 1"});
  expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                 {});
  expect_outcome(wait_to_end(desk), 0, {});
  EXPECT_TRUE(std::filesystem::exists(model_ / "model.json"));
  EXPECT_TRUE(std::filesystem::exists(report_));
}

class EndsOfMany : public Ends {
 protected:
  EndsOfMany() : Ends(kManyViews) {}
};

TEST_F(EndsOfMany, ASecondSignalEndsItAtOnceAndKeepsSessionAndOlderModel) {
  const auto first = captured();
  first->signal(SIGINT);
  expect_outcome(wait_to_end(*first), 0, {"the model is saved"});
  const std::string older = read_file(model_ / "model.json");

  Process desk(serve(data_.mesh(), session_, {"--endpoint", free_address()}));
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience)) << desk.output();
  desk.signal(SIGTERM);
  ASSERT_TRUE(desk.prints("finishing", kPatience)) << desk.output();
  desk.signal(SIGINT);
  const auto end = desk.wait(kStopPatience);
  ASSERT_TRUE(end) << "still runs after the second signal:\n" << desk.output();
  expect_outcome({*end, desk.output()}, 1,
                 {"nothing is lost: " + std::to_string(kManyViews) + " captures", "same command",
                  "build " + session_.string() + " --mesh"});
  EXPECT_TRUE(read_file(model_ / "model.json") == older);
  EXPECT_EQ(captures_of(session_).size(), std::size_t{kManyViews});
}

TEST_F(EndsOfMany, TheStatusPageSaysWhatIsStillDone) {
  { const auto desk = captured(); }  // killed: no model
  const std::string url = "http://127.0.0.1:" + std::to_string(free_port());
  Process desk(reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--headless", "--endpoint",
                              free_address(), "--monitor-port", url.substr(url.rfind(':') + 1)}));
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience)) << desk.output();
  desk.signal(SIGINT);
  std::set<std::string> states;
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       desk.running() && std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(milliseconds(20))) {
    try {
      const Json status = Json::parse(fetch_status(url, ""));
      states.insert(status["state"]);
      if (status["state"] == "finishing") {
        EXPECT_LE(status["ending"]["done"], status["ending"]["total"]);
        EXPECT_EQ(status["frames"]["received"], kManyViews);
      }
    } catch (const std::exception&) {  // it has just ended
    }
  }
  EXPECT_TRUE(states.contains("finishing")) << desk.output();
  EXPECT_FALSE(states.contains("stalled"));
  expect_outcome(wait_to_end(desk), 0, {"the model is saved", "dB lost"});
  EXPECT_TRUE(std::filesystem::is_regular_file(model_));
}

}  // namespace
}  // namespace sheen::testing
