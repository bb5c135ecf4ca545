// SPDX-License-Identifier: Apache-2.0
// An image is taken back: from a stored session, from one that is being recorded, through kill -9.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/session/session.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/breaking_peer.h"
#include "tests/support/temp_folder.h"

#include <httplib.h>  // behind Eigen: it brings a macro of the name _res

namespace sheen::testing {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class Undo : public ::testing::Test {
 protected:
  Undo() { data_.write(); }

  /// Records all views; `serve` goes on waiting for more.
  void record() {
    const std::string address = free_address();
    desk_ = std::make_unique<Process>(serve_command(address));
    expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                   {"16 keyframes sent"});
  }
  Words serve_command(const std::string& address) const {
    return serve(data_.mesh(), session_, {"--endpoint", address, "--config", data_.scene(), "--json", live_});
  }
  void undo(const Words& what, const Words& says) {
    expect_outcome(run_to_end(reconstructor({"undo", session_}) + what), 0, says);
  }
  void undo_fails(const Words& what, int status, const Words& says) {
    expect_outcome(run_to_end(reconstructor({"undo", session_}) + what), status, says);
  }
  Json build(const std::filesystem::path& out) const {
    const auto report = temp_.path() / "build.json";
    expect_outcome(run_to_end(reconstructor({"build", session_, "--mesh", data_.mesh(), "--config", data_.scene(),
                                             "--out", out, "--loss", "0dB", "--json", report})),
                   0, {});
    return Json::parse(read_file(report));
  }
  /// A session that never had the captures in `missing`, built.
  void build_without(const std::set<std::uint64_t>& missing, const std::filesystem::path& out) const {
    const auto never = temp_.path() / ("never" + std::to_string(counter_++));
    {
      const Session all = Session::open_read_only(session_);
      Session session = Session::create(never);
      for (std::uint64_t i = 0; i < all.size(); ++i)
        if (!missing.contains(i)) session.append(all.read(i));
    }
    expect_outcome(run_to_end(reconstructor({"build", never, "--mesh", data_.mesh(), "--config", data_.scene(), "--out",
                                             out, "--loss", "0dB"})),
                   0, {});
  }
  static void expect_sum(const Json& frames) {
    std::uint64_t refused = 0;
    for (const auto& [reason, n] : frames["refused"].items()) refused += n.get<std::uint64_t>();
    EXPECT_EQ(frames["sent"].get<std::uint64_t>(),
              frames["accepted"].get<std::uint64_t>() + frames["held_out"].get<std::uint64_t>() + refused +
                  frames["withdrawn"].get<std::uint64_t>() + frames["lost"].get<std::uint64_t>());
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data"};  // views 4 and 12 are held out
  const std::filesystem::path session_ = temp_.path() / "session", live_ = temp_.path() / "live.json";
  std::unique_ptr<Process> desk_;
  mutable int counter_ = 0;
};

TEST_F(Undo, AStoredSessionsModelIsTheOneThatNeverSawTheImages) {
  record();
  desk_->signal(SIGINT);
  wait_to_end(*desk_);
  undo({"--list"}, {"0\tkept\t", "15\tkept\t"});
  undo({"--capture", "0"}, {"capture 0 is withdrawn"});  // the first: it decides about maps and exposures
  undo({"--capture", "0"}, {"capture 0 was already withdrawn"});
  undo({"--last"}, {"capture 15 is withdrawn"});
  undo({"--last"}, {"capture 14 is withdrawn"});
  undo({"--name", "1012.png"}, {"capture 12 is withdrawn"});  // held out
  undo({"--list"}, {"0\twithdrawn", "1\tkept", "15\twithdrawn"});
  const Json report = build(temp_.path() / "undone");
  EXPECT_EQ(report["frames"]["withdrawn"], 4);
  EXPECT_EQ(report["frames"]["held_out"], 1);
  EXPECT_EQ(report["frames"]["accepted"], 11);
  expect_sum(report["frames"]);
  build_without({0, 12, 14, 15}, temp_.path() / "never_saw");
  expect_same_model(temp_.path() / "undone", temp_.path() / "never_saw");

  undo({"--restore", "--capture", "14"}, {"capture 14 is put back"});
  EXPECT_EQ(build(temp_.path() / "restored")["frames"]["withdrawn"], 3);
}

TEST_F(Undo, WhileASessionIsRecordedAndThroughAKill) {
  record();
  undo({"--capture", "3"}, {"capture 3 is withdrawn"});
  undo({"--last"}, {"capture 15 is withdrawn"});
  EXPECT_TRUE(desk_->running());
  desk_->kill();

  const std::string address = free_address();
  desk_ = std::make_unique<Process>(serve_command(address) + Words{"--once"});
  undo({"--capture", "12"}, {"capture 12 is withdrawn"});  // of a session that is being resumed
  expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                 {"16 keyframes sent"});
  expect_outcome(wait_to_end(*desk_), 0, {"12 images added to the model", "1 held out, 3 withdrawn"});
  const Json report = Json::parse(read_file(live_));
  EXPECT_EQ(report["frames"]["withdrawn"], 3);
  EXPECT_EQ(report["frames"]["journaled"], 16);
  expect_sum(report["frames"]);
  build_without({3, 12, 15}, temp_.path() / "never_saw");
  expect_same_model(session_ / "model", temp_.path() / "never_saw");
}

TEST_F(Undo, ADamagedFileIsListedAndLeftOutAndALostLogCostsNothing) {
  record();
  desk_->kill();
  std::filesystem::resize_file(session_ / "captures/00000005.capture", 100);
  undo({"--list"}, {"4\tkept\t", "5\tdamaged", "6\tkept\t", "00000005.capture", "undo --capture 5"});
  const Json report = build(temp_.path() / "built");
  EXPECT_EQ(report["frames"]["refused"], (Json{{"damaged file", 1}}));
  EXPECT_EQ(report["frames"]["accepted"], 13);
  expect_sum(report["frames"]);
  build_without({5}, temp_.path() / "never_saw");
  expect_same_model(temp_.path() / "built", temp_.path() / "never_saw");

  ASSERT_TRUE(std::filesystem::remove(session_ / "session.sqlite-wal"));  // as a copy of the two files only has it
  const Json again = build(temp_.path() / "again");
  EXPECT_EQ(again["frames"]["accepted"], 13);
  expect_same_model(temp_.path() / "again", temp_.path() / "never_saw");
  undo({"--last"}, {"capture 14 is withdrawn", "15 captures missing from the index", "00000005.capture.damaged"});
}

TEST_F(Undo, WhatIsNotThereIsNamed) {
  undo_fails({"--last"}, 1, {"holds no session"});
  { Session::create(session_); }
  undo_fails({"--last"}, 1, {"no capture that could be taken back"});
  undo_fails({"--capture", "3"}, 1, {"no capture 3"});
  undo_fails({"--name", "hand.png"}, 1, {"no capture named 'hand.png'"});
  undo_fails({}, 2, {"--last, --capture, --name or --list"});
  undo_fails({"--last", "--capture", "1"}, 2, {"give one of"});
  undo_fails({"--restore", "--last"}, 2, {"--restore needs"});
}

class Steered : public ::testing::Test {
 protected:
  Steered() { data_.write(); }
  std::string post(const std::string& query) {
    httplib::Client client("127.0.0.1", port_);
    const auto answer =
        client.Post("/steer?" + query, {{"Authorization", std::string("Bearer ") + kToken}}, "", "text/plain");
    return answer ? answer->body : "no answer";
  }

  static constexpr const char* kToken = "fedcba9876543210";
  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data"};
  const std::filesystem::path session_ = temp_.path() / "session";
  const int port_ = port_of(free_address());
};

TEST_F(Steered, FromAnotherDeskAnImageIsTakenBackANoteIsWrittenAndTheCaptureEnds) {
  const auto token = temp_.write("steer.token", std::string(kToken) + "\n");
  std::filesystem::permissions(token, std::filesystem::perms::owner_read);
  const std::string address = free_address();
  Words command = reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--headless", "--endpoint",
                                 address, "--monitor-port", std::to_string(port_), "--steer-token-file", token,
                                 "--json", temp_.path() / "report.json"});
  Process desk(command);
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience)) << desk.output();
  EXPECT_EQ(post("what=hold-out"), "asked for\n");
  ASSERT_TRUE(desk.prints("the next image is held out", kPatience)) << desk.output();
  expect_outcome(run_to_end(patient_run({"--source", "dataset:" + data_.folder.string(), "--endpoint", address})), 0,
                 {"16 keyframes sent"});
  EXPECT_EQ(post("what=undo"), "asked for\n");
  EXPECT_EQ(post("what=note&text=the%20left%20lamp%20was%20off"), "asked for\n");
  ASSERT_TRUE(desk.prints("the left lamp was off", kPatience)) << desk.output();
  EXPECT_EQ(post("what=finish"), "asked for\n");
  expect_outcome(wait_to_end(desk), 0, {"127.0.0.1: image 15 is taken back", "the model is saved"});

  const Session session = Session::open_read_only(session_);
  EXPECT_EQ(session.withdrawn(), std::set<std::uint64_t>{15});
  const std::string written = session.metadata("steering").value_or("");
  EXPECT_NE(written.find("Z 127.0.0.1: image 15 is taken back\n"), std::string::npos) << written;
  EXPECT_NE(written.find(": note: the left lamp was off\n"), std::string::npos) << written;
  EXPECT_NE(written.find(": the capture is finished\n"), std::string::npos) << written;
  EXPECT_EQ(Json::parse(read_file(temp_.path() / "report.json"))["steering"].size(), 4u);
  EXPECT_EQ(session.read(0).purpose, Purpose::kHeldOut);
  EXPECT_NE(session.read(1).purpose, Purpose::kHeldOut);
}

/// Images that come while a capture is paused are stored, and the model is one that never saw them.
TEST_F(Steered, WhatComesWhileItIsPausedIsStoredAndNotInTheModel) {
  const auto token = temp_.write("steer.token", std::string(kToken) + "\n");
  std::filesystem::permissions(token, std::filesystem::perms::owner_read);
  const std::string address = free_address();
  Process desk(reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--headless", "--endpoint",
                              address, "--monitor-port", std::to_string(port_), "--steer-token-file", token, "--json",
                              temp_.path() / "report.json"}));
  ASSERT_TRUE(desk.prints("waiting for a tracker", kPatience)) << desk.output();
  EXPECT_EQ(post("what=pause"), "asked for\n");
  ASSERT_TRUE(desk.prints("paused: images are stored", kPatience)) << desk.output();
  const BallDataset later{.folder = temp_.path() / "later", .views = 12};
  later.write();
  const auto send = [&](const BallDataset& images, const std::string& sent) {
    expect_outcome(run_to_end(patient_run({"--source", "dataset:" + images.folder.string(), "--endpoint", address})), 0,
                   {sent});
  };
  send(data_, "16 keyframes sent");
  EXPECT_EQ(post("what=go-on"), "asked for\n");
  ASSERT_TRUE(desk.prints("images are added again", kPatience)) << desk.output();
  send(later, "12 keyframes sent");
  EXPECT_EQ(post("what=finish"), "asked for\n");
  expect_outcome(wait_to_end(desk), 0, {"the model is saved"});
  const Json frames = Json::parse(read_file(temp_.path() / "report.json"))["frames"];
  EXPECT_EQ(frames["withdrawn"], 16);
  EXPECT_EQ(frames["accepted"].get<int>() + frames["held_out"].get<int>(), 12) << frames;
  EXPECT_EQ(Session::open_read_only(session_).withdrawn().size(), 16u);
}

}  // namespace
}  // namespace sheen::testing
