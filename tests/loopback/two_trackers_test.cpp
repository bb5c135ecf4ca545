// SPDX-License-Identifier: Apache-2.0
// Two trackers that stream photographs into one reconstructor.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

class TwoTrackers : public ::testing::Test {
 protected:
  TwoTrackers() {
    few_.write();
    many_.write();
  }
  static Words track(const BallDataset& data, const std::string& endpoint) {
    return patient_run({"--source", "dataset:" + data.folder.string(), "--endpoint", endpoint});
  }
  Words desk(const Words& more) const {
    return serve(few_.mesh(), session_, Words{"--endpoint", a_, "--endpoint", b_} + more);
  }
  /// How many captures of each source the session has; they are the first ones, in order.
  std::map<std::string, std::uint64_t> stored() const {
    std::map<std::string, std::uint64_t> last;
    for (const auto& [source, sequence] : captures_of(session_)) EXPECT_EQ(sequence, ++last[source]);
    return last;
  }

  const TempFolder temp_;
  const BallDataset few_{.folder = temp_.path() / "few", .views = 8};
  const BallDataset many_{.folder = temp_.path() / "many", .views = kManyViews};
  const std::filesystem::path session_ = temp_.path() / "session";
  const std::string a_ = free_address(), b_ = free_address();
};

TEST_F(TwoTrackers, OneThatIsKilledKeepsTheOtherFromNothingAndComesBack) {
  Process keeping(desk({"--once", "--json", temp_.path() / "desk.json"}));
  Process rig(track(many_, b_));
  while (rig.running() && captures_so_far(session_) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  rig.kill();
  expect_outcome(run_to_end(track(few_, a_)), 0, {"8 keyframes sent"});
  EXPECT_TRUE(keeping.running()) << "the other tracker has not ended: " << keeping.output();
  expect_outcome(run_to_end(track(many_, b_)), 0, {std::to_string(kManyViews) + " keyframes sent"});
  expect_outcome(wait_to_end(keeping), 0, {"images added to the model", "endpoint=" + a_, "endpoint=" + b_});

  const auto sources = stored();
  ASSERT_EQ(sources.size(), 2u);
  const auto report = nlohmann::json::parse(read_file(temp_.path() / "desk.json"));
  EXPECT_EQ(report["frames"]["received"], 8 + kManyViews);
  EXPECT_EQ(report["frames"]["lost"], 0);
  EXPECT_EQ(report["trackers"][0]["received"], 8);
  EXPECT_EQ(report["trackers"][1]["received"], kManyViews);
}

TEST_F(TwoTrackers, WhatTheyGaveIsTheModelOfTheirSession) {
  Process keeping(desk({"--once"}));
  Process rig(track(few_, a_)), other(track(many_, b_));
  expect_outcome(wait_to_end(rig), 0, {"8 keyframes sent"});
  expect_outcome(wait_to_end(other), 0, {std::to_string(kManyViews) + " keyframes sent"});
  expect_outcome(wait_to_end(keeping), 0, {"images added to the model"});
  const auto built = temp_.path() / "built";
  expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", few_.mesh(), "--out", built, "--loss", "0dB"})),
                 0, {});
  expect_same_model(built, session_ / "model");
}

TEST_F(TwoTrackers, TheSamePhotographsFromBothAreStoredOnce) {
  Process keeping(desk({"--once"}));
  Process rig(track(few_, a_)), other(track(few_, b_));
  expect_outcome(wait_to_end(rig), 0, {"8 keyframes sent"});
  expect_outcome(wait_to_end(other), 0, {"8 keyframes sent"});
  expect_outcome(wait_to_end(keeping), 0, {"images added to the model"});
  EXPECT_EQ(captures_of(session_).size(), 8u);
}

TEST_F(TwoTrackers, WrongOptionsAreNamed) {
  expect_outcome(run_to_end(serve(few_.mesh(), session_, {"--endpoint", a_, "--endpoint", a_})), 2,
                 {a_ + " is given twice"});
  const SecureLink link(temp_.path());
  const Words three_keys{"--tracker-key", temp_.path() / "tracker.pub", "--tracker-key", temp_.path() / "tracker.pub"};
  expect_outcome(
      run_to_end(
          desk(Words{"--keys", temp_.path() / "desk.key", "--tracker-key", temp_.path() / "tracker.pub"} + three_keys)),
      2, {"3 keys for 2 trackers"});
}

}  // namespace
}  // namespace sheen::testing
