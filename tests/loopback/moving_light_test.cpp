// SPDX-License-Identifier: Apache-2.0
// Light that moves through the live stream: images are sent with their light, recorded with it, and give the model that
// the files give; killed, resumed and taken back.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/datasets/light_list.h"
#include "common/session/session.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/loopback/lit_ball.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Models of moving light are the same to the bit: every file, and of model.json all but what it says of its making.
void expect_same_lit_model(const fs::path& a, const fs::path& b) {
  std::size_t files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(a)) {
    const std::string name = entry.path().filename();
    ASSERT_TRUE(fs::exists(b / name)) << name;
    ++files;
    if (name == "model.json") {
      Json in_a = Json::parse(read_file(a / name)), in_b = Json::parse(read_file(b / name));
      in_a.erase("metadata");
      in_b.erase("metadata");
      EXPECT_TRUE(in_a == in_b);
    } else {
      EXPECT_TRUE(read_file(a / name) == read_file(b / name)) << name;
    }
  }
  EXPECT_EQ(files, static_cast<std::size_t>(std::distance(fs::directory_iterator(b), fs::directory_iterator())));
  EXPECT_GE(files, 2u);
}

class MovingLight : public ::testing::Test {
 protected:
  MovingLight() { ball_.write(); }

  static Words serve(const fs::path& session, const Words& more) {
    return reconstructor({"serve", "--session", session, "--no-monitor", "--loss", "0dB"}) + more;
  }
  Words serve_field(const Words& more) const {
    return serve(session_, Words{"--model", "irradiance-field", "--endpoint", address_} + more);
  }
  Words track(const fs::path& data) const {
    return patient_run({"--source", "dataset:" + data.string(), "--endpoint", address_});
  }
  void expect_lights_of_the_list(const fs::path& session) const {
    const LightList list = load_light_list(ball_.list());
    const Session recorded = Session::open_read_only(session);
    ASSERT_EQ(recorded.size(), list.views.size());
    for (std::uint64_t i = 0; i < recorded.size(); ++i) {
      const Capture capture = recorded.read(i);
      EXPECT_EQ(capture.light.kind, LightKind::kDirectional);
      EXPECT_EQ(capture.light.position, list.views[i].light.position) << i;
      EXPECT_EQ(capture.light.rgb, list.views[i].light.rgb) << i;
    }
  }
  fs::path built(const fs::path& data) const {
    const fs::path model = temp_.path() / "built";
    fs::remove_all(model);
    expect_outcome(
        run_to_end(reconstructor({"build", data, "--model", "irradiance-field", "--out", model, "--loss", "0dB"})), 0,
        {});
    return model;
  }
  /// The ball's list without some of its images.
  fs::path list_without(const std::set<std::size_t>& missing) const {
    const LightList all = load_light_list(ball_.list());
    std::string text = std::to_string(all.views.size() - missing.size()) + "\n";
    std::istringstream lines(read_file(ball_.list()));
    std::string line;
    std::getline(lines, line);
    for (std::size_t i = 0; std::getline(lines, line); ++i)
      if (!missing.contains(i)) text += line + "\n";
    write_file(ball_.folder / "some.lp", text);
    return ball_.folder / "some.lp";
  }

  const TempFolder temp_;
  const LitBall ball_{.folder = temp_.path() / "ball"};
  const fs::path session_ = temp_.path() / "session";
  const std::string address_ = free_address();
};

TEST_F(MovingLight, AStreamedListGivesTheFieldOfItsFiles) {
  const SecureLink link(temp_.path());
  const fs::path report = temp_.path() / "desk.json";
  Process desk(serve(session_, Words{"--model", "irradiance-field", "--headless", "--once", "--json", report} +
                                   link.reconstructor_options()));
  expect_outcome(run_to_end(patient_run({"--source", "dataset:" + ball_.list().string()}) + link.tracker_options()), 0,
                 {"24 keyframes sent"});
  expect_outcome(wait_to_end(desk), 0, {"24 images added to the model", "the model is saved"});
  expect_lights_of_the_list(session_);
  expect_same_lit_model(built(ball_.list()), session_ / "model");
  expect_same_lit_model(built(session_), session_ / "model");
  const Json got = Json::parse(read_file(report));
  EXPECT_EQ(got["settings"]["model"], "irradiance_field");
  EXPECT_EQ(got["frames"]["received"], 24);
  EXPECT_EQ(got["frames"]["lost"], 0);
}

TEST_F(MovingLight, KilledWithItsLightsItGoesOn) {
  auto desk = std::make_unique<Process>(serve_field({"--headless", "--once"}));
  Process rig(track(ball_.list()));
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       captures_so_far(session_) < 5 && std::chrono::steady_clock::now() < end;)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  desk->kill();
  EXPECT_GE(captures_so_far(session_), 5u);
  desk = std::make_unique<Process>(serve_field({"--headless", "--once"}));
  wait_to_end(rig);
  // It may have ended for the desk that was killed: then it is wanted once more.
  if (!desk->wait(std::chrono::seconds(3))) run_to_end(track(ball_.list()));
  expect_outcome(wait_to_end(*desk), 0, {"resumed", "24 images added to the model"});
  expect_lights_of_the_list(session_);
  expect_same_lit_model(built(ball_.list()), session_ / "model");
}

TEST_F(MovingLight, ALitImageIsTakenBack) {
  Process desk(serve_field({"--headless"}));
  expect_outcome(run_to_end(track(ball_.list())), 0, {"24 keyframes sent"});
  for (const Words& what : {Words{"--capture", "0"}, Words{"--capture", "7"}, Words{"--last"}})
    expect_outcome(run_to_end(reconstructor({"undo", session_}) + what), 0, {"is withdrawn"});
  desk.signal(SIGINT);
  expect_outcome(wait_to_end(desk), 0, {"21 images added to the model", "3 withdrawn"});
  const fs::path never_saw = built(list_without({0, 7, 23}));
  expect_same_lit_model(never_saw, session_ / "model");
  expect_same_lit_model(built(session_), session_ / "model");
}

TEST_F(MovingLight, IsSeenInTheWindow) {
  Process desk(Words{SHEEN_WITH_XVFB} + serve_field({"--once"}));
  Process rig(track(ball_.list()));
  const Outcome outcome = wait_to_end(desk);
  if (outcome.output.find("without a display") != std::string::npos) {
    rig.signal(SIGINT);
    GTEST_SKIP() << "no Xvfb here";
  }
  expect_outcome(outcome, 0, {"24 images added to the model"});
  expect_outcome(wait_to_end(rig), 0, {"24 keyframes sent"});
  expect_same_lit_model(built(ball_.list()), session_ / "model");
}

/// A still life in five lights, from two places.
class MovingLightAndCamera : public MovingLight {
 protected:
  MovingLightAndCamera() {
    expect_outcome(
        run_to_end(tracker({"simulate", "--out", rig_, "--lights", "5", "--views", "2x1", "--size", "160x120"})), 0,
        {"5 lights"});
  }
  const fs::path rig_ = temp_.path() / "rig", mesh_ = rig_ / "mesh.ply";
};

TEST_F(MovingLightAndCamera, AStreamedDataSetGivesTheLumigraphOfItsFiles) {
  const Words model{"--model", "intrinsic-lumigraph", "--mesh", mesh_};
  Process desk(serve(session_, model + Words{"--headless", "--endpoint", address_}));
  expect_outcome(run_to_end(track(rig_)), 0, {"keyframes sent"});
  desk.kill();
  Process again(serve(session_, model + Words{"--headless", "--endpoint", address_}));
  ASSERT_TRUE(again.prints("resumed", kPatience)) << again.output();
  expect_outcome(run_to_end(reconstructor({"undo", session_, "--capture", "3"})), 0, {"is withdrawn"});
  again.signal(SIGINT);
  expect_outcome(wait_to_end(again), 0, {"9 images added to the model", "1 withdrawn"});
  const fs::path of_session = temp_.path() / "of_session", of_files = temp_.path() / "of_files";
  expect_outcome(run_to_end(reconstructor({"build", session_, "--out", of_session, "--loss", "0dB"}) + model), 0, {});
  expect_same_lit_model(of_session, session_ / "model");

  expect_outcome(run_to_end(reconstructor({"undo", session_, "--restore", "--capture", "3"})), 0, {});
  expect_outcome(run_to_end(reconstructor({"build", session_, "--out", of_session, "--loss", "0dB"}) + model), 0,
                 {"10 images added"});
  expect_outcome(run_to_end(reconstructor({"build", rig_, "--out", of_files, "--loss", "0dB"}) + model), 0,
                 {"10 images added"});
  expect_same_lit_model(of_files, of_session);
}

TEST_F(MovingLightAndCamera, AutoIsForWhatMoves) {
  const BallDataset fixed{.folder = temp_.path() / "fixed", .views = 6};
  fixed.write();
  const fs::path report = temp_.path() / "report.json", scene = temp_.write("auto.toml", "model = \"auto\"\n");
  const auto expect_choice = [&](const std::string& model, const std::string& why) {
    const Json json = Json::parse(read_file(report));
    EXPECT_EQ(json["settings"]["model"], model);
    EXPECT_EQ(json["model_choice"]["model"], model);
    EXPECT_EQ(json["model_choice"]["why"], why);
  };
  struct Case {
    fs::path data;
    Words mesh;
    std::string model, why;
  };
  const std::vector<Case> cases{
      {fixed.folder, {"--mesh", fixed.mesh()}, "surface_light_field", "the camera moves and the light stands still"},
      {ball_.list(), {}, "irradiance_field", "the camera stands still and the light moves"},
      {rig_, {"--mesh", mesh_}, "intrinsic_lumigraph", "the camera moves and the light moves"}};
  for (const Case& c : cases) {
    const fs::path session = temp_.path() / (c.model + "_session"), model = temp_.path() / (c.model + "_built");
    expect_outcome(run_to_end(reconstructor({"build", c.data, "--model", "auto", "--out", model, "--loss", "0dB",
                                             "--json", report}) +
                              c.mesh),
                   0, {"the model is chosen: " + c.model + ", because " + c.why});
    expect_choice(c.model, c.why);

    const Words command = serve(
        session, c.mesh + Words{"--config", scene, "--headless", "--once", "--endpoint", address_, "--json", report});
    Process desk(command);
    expect_outcome(run_to_end(track(c.data)), 0, {"keyframes sent"});
    expect_outcome(wait_to_end(desk), 0, {"chosen: " + c.model + ", because " + c.why});
    expect_choice(c.model, c.why);
    const Words named{"build",  session, "--model", "auto", "--out", temp_.path() / (c.model + "_again"),
                      "--loss", "0dB"};
    expect_outcome(run_to_end(reconstructor(named) + c.mesh), 0, {"the model is chosen: " + c.model});
    expect_same_lit_model(model, session / "model");
    expect_same_lit_model(temp_.path() / (c.model + "_again"), session / "model");
  }
  expect_outcome(run_to_end(reconstructor({"refine", fixed.folder, "--mesh", fixed.mesh(), "--out",
                                           temp_.path() / "r.ply", "--config", scene})),
                 2, {"auto.toml:1", "only `build` and `serve` choose it"});
}

TEST_F(MovingLightAndCamera, WhatWasChosenStays) {
  const Words command = serve(session_, {"--model", "auto", "--headless", "--endpoint", address_});
  auto desk = std::make_unique<Process>(command);
  expect_outcome(run_to_end(track(ball_.list())), 0, {"24 keyframes sent"});
  desk->kill();
  desk = std::make_unique<Process>(command);  // nobody announces anything now: it is noted
  ASSERT_TRUE(desk->prints("chosen: irradiance_field", kPatience)) << desk->output();
  expect_outcome(run_to_end(track(rig_)), 0, {"keyframes sent"});  // another rig: its camera moves
  EXPECT_TRUE(desk->prints("the camera moves, but this model", kPatience)) << desk->output();
  desk->signal(SIGINT);
  expect_outcome(wait_to_end(*desk), 0, {"24 images added to the model", "takes it to stand still", "--model auto"});
}

TEST_F(MovingLight, TheStatusSaysWhatIsAwaitedAndChosen) {
  const int port = free_port();
  Process desk(reconstructor({"serve", "--session", session_, "--model", "auto", "--headless", "--endpoint", address_,
                              "--monitor-port", std::to_string(port)}));
  const Words watch =
      reconstructor({"monitor", "--url", "http://127.0.0.1:" + std::to_string(port), "--json", "--once"});
  const auto eventually = [&](const std::function<bool(const Json&)>& holds) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
      const Outcome outcome = run_to_end(watch);
      if (outcome.end.status == 0 && holds(Json::parse(outcome.output))) return true;
    }
    return false;
  };
  EXPECT_TRUE(eventually([](const Json& s) { return s["model"] == "" && !s["hint"].get<std::string>().empty(); }));
  expect_outcome(run_to_end(track(ball_.list())), 0, {"24 keyframes sent"});
  EXPECT_TRUE(eventually([](const Json& s) {
    return s["model"] == "irradiance_field" && s["model_reason"] == "the camera stands still and the light moves" &&
           s["frames"]["accepted"] == 24;
  }));
  desk.signal(SIGINT);
  expect_outcome(wait_to_end(desk), 0, {"24 images added to the model"});
}

TEST_F(MovingLight, WrongUseIsTold) {
  expect_outcome(run_to_end(reconstructor({"serve", "--session", session_, "--headless", "--refine"})), 2,
                 {"--refine corrects a mesh that is given"});
  expect_outcome(run_to_end(serve_field({"--headless", "--mesh", "object.ply"})), 2,
                 {"--mesh", "makes its own surface; leave it out"});
  EXPECT_FALSE(fs::exists(session_));
  Process waiting(serve_field({"--headless"}));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  waiting.signal(SIGINT);
  expect_outcome(wait_to_end(waiting), 0, {"waiting for a tracker", "ended before the capture began"});

  const BallDataset fixed{.folder = temp_.path() / "fixed", .views = 6};
  fixed.write();
  Process desk(serve_field({"--headless", "--once"}));
  expect_outcome(run_to_end(track(fixed.folder)), 0, {"6 keyframes sent"});
  expect_outcome(wait_to_end(desk), 1, {"none of its 6 captures can be used", "needs a light in each"});
  expect_outcome(run_to_end(reconstructor({"serve", "--session", session_, "--mesh", fixed.mesh(), "--headless"})), 2,
                 {"was started without a mesh"});
}

}  // namespace
}  // namespace sheen::testing
