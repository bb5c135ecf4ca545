// SPDX-License-Identifier: Apache-2.0
// What goes wrong for a user before anything is captured: exit status, and a message that names the culprit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "common/image/image_io.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;

class BadInput : public ::testing::Test {
 protected:
  BadInput() { data_.write(); }

  Outcome build(const Words& more = {}) {
    return run_to_end(reconstructor({"build", data_.folder, "--mesh", data_.mesh()}) + more);
  }
  Outcome serve_once(const Words& more = {}, const std::string& address = free_address()) {
    return run_to_end(serve(data_.mesh(), session_, Words{"--once", "--endpoint", address} + more));
  }
  Outcome track(const Words& more = {}, const std::string& address = free_address(), const char* linger_s = "0") {
    return run_to_end(
        tracker({"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", address, "--linger", linger_s}) +
        more);
  }
  void change(const fs::path& file, const std::string& from, const std::string& to) {
    std::string text = read_file(file);
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    std::ofstream(file, std::ios::trunc) << text;
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data", .views = 4};
  const fs::path session_ = temp_.path() / "session";
  const fs::path image_ = data_.folder / "images" / "1002.png";
};

TEST_F(BadInput, AMissingMesh) {
  fs::remove(data_.mesh());
  expect_outcome(build(), 1, {"mesh.ply: no such file"});
  expect_outcome(serve_once(), 1, {"mesh.ply: no such file"});
  EXPECT_FALSE(fs::exists(session_)) << "begun although nothing can be done with it";
}

TEST_F(BadInput, ABrokenMesh) {
  fs::resize_file(data_.mesh(), 600);
  expect_outcome(build(), 1, {"mesh.ply"});
  expect_outcome(serve_once(), 1, {"mesh.ply"});
  std::ofstream(data_.mesh(), std::ios::trunc) << "no mesh\n";
  expect_outcome(build(), 1, {"mesh.ply"});
}

TEST_F(BadInput, AMissingDataset) {
  const auto nowhere = temp_.path() / "nowhere";
  expect_outcome(run_to_end(reconstructor({"build", nowhere, "--mesh", data_.mesh()})), 1, {"nowhere: no such folder"});
  expect_outcome(run_to_end(tracker({"run", "--source", "dataset:" + nowhere.string()})), 1,
                 {"nowhere: no such folder"});
}

TEST_F(BadInput, ABrokenDescription) {
  const auto file = data_.folder / "transforms.json";
  const std::string good = read_file(file);
  fs::resize_file(file, 200);
  for (const Outcome& outcome : {build(), track()}) expect_outcome(outcome, 1, {"transforms.json", "not valid JSON"});
  std::ofstream(file, std::ios::trunc) << good;
  change(file, "\"transform_matrix\"", "\"transform\"");
  for (const Outcome& outcome : {build(), track()})
    expect_outcome(outcome, 1, {"transforms.json", "frame 0", "transform_matrix"});
}

TEST_F(BadInput, AnImageOfAnotherSize) {
  write_png(image_, ImageU8(80, 60, 3, 100));
  for (const Outcome& outcome : {build(), track()}) expect_outcome(outcome, 1, {"1002.png", "80", "160"});
}

TEST_F(BadInput, AnImageThatIsCutOff) {
  fs::resize_file(image_, 2000);
  const fs::path report = temp_.path() / "report.json";
  expect_outcome(build({"--json", report}), 0, {"3 of 4 images", "left out: images/1002.png", "damaged PNG"});
  const auto files = nlohmann::json::parse(read_file(report))["files"];
  EXPECT_EQ(files["images"], 3);
  ASSERT_EQ(files["left_out"].size(), 1u);
  EXPECT_EQ(files["left_out"][0]["name"], "images/1002.png");
  expect_outcome(track(), 1, {"3 of 4 images", "left out: images/1002.png", "damaged PNG", "3 keyframes"});
}

TEST_F(BadInput, AnImageThatIsCutOffTakesNoneOfTheOthersWithIt) {
  fs::resize_file(image_, 2000);  // the third of four
  const std::string address = free_address();
  const fs::path report = temp_.path() / "rig.json";
  Process desk(serve(data_.mesh(), session_, {"--once", "--endpoint", address}));
  expect_outcome(track({"--json", report}, address, "30"), 0, {"1002.png", "damaged PNG", "3 keyframes sent"});
  expect_outcome(wait_to_end(desk), 0, {"3 images added to the model"});
  EXPECT_EQ(captures_of(session_).size(), 3u);
  EXPECT_EQ(nlohmann::json::parse(read_file(report))["link"]["acknowledged"], 3);
}

TEST_F(BadInput, AChangedImageIsAnotherDataset) {
  const std::string address = free_address();
  const auto capture = [&] {
    Process desk(serve(data_.mesh(), session_, {"--once", "--endpoint", address}));
    expect_outcome(track({}, address, "30"), 0, {"4 keyframes sent"});
    expect_outcome(wait_to_end(desk), 0, {});
    return captures_of(session_);
  };
  ASSERT_EQ(capture().size(), 4u);
  ASSERT_EQ(capture().size(), 4u) << "the same images are known";
  write_png(image_, ImageU8(data_.width, data_.height, 3, 100));
  const auto captures = capture();
  ASSERT_EQ(captures.size(), 8u) << "a changed image is not";
  EXPECT_NE(captures[0].first, captures[4].first);
}

TEST_F(BadInput, KeyframesThatNobodyTookAreNoSuccess) {
  expect_outcome(track(), 1, {"4 keyframes were not acknowledged", "sheen-reconstructor serve", "again"});
  Process rig(tracker({"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", free_address()}));
  ASSERT_TRUE(rig.prints(" to tcp://", kPatience)) << rig.output();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  rig.signal(SIGINT);
  expect_outcome(wait_to_end(rig), 1, {"keyframes were not acknowledged"});
}

// The image is left out, and that is said: the others are as good as before.
TEST_F(BadInput, AMissingMask) {
  fs::remove(data_.folder / "masks" / "1002.png");
  const Words said{"3 of 4 images, 3 masks", "left out: images/1002.png", "masks/1002.png"};
  expect_outcome(build(), 0, said);
  expect_outcome(track(), 1, said + Words{"3 keyframes were not acknowledged"});  // nobody listens
}

TEST_F(BadInput, AnUnknownKeyInAConfiguration) {
  std::ofstream(data_.scene(), std::ios::trunc) << "[surface_light_field]\nsurface_mapp = 4\n";
  expect_outcome(serve_once({"--config", data_.scene()}), 2,
                 {"scene.toml:2", "unknown key surface_mapp", "has", "surface_map,"});
  const auto rig = temp_.write("rig.toml", "[camera]\nwidht = 640\n");
  expect_outcome(track({"--config", rig}), 2, {"rig.toml:2", "camera.widht", "width"});
}

TEST_F(BadInput, ASessionOfANewerVersion) {
  Process begun(serve(data_.mesh(), session_, {"--endpoint", free_address()}));
  while (begun.running() && !fs::exists(session_ / "session.sqlite")) {
  }
  begun.kill();
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((session_ / "session.sqlite").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "PRAGMA user_version = 7", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  expect_outcome(serve_once(), 1, {"session.sqlite", "version 7", "up to version 2", "newer release"});
}

TEST_F(BadInput, ASessionThatWasBegunWithAnotherMesh) {
  Process begun(serve(data_.mesh(), session_, {"--endpoint", free_address()}));
  ASSERT_TRUE(begun.prints("waiting for a tracker", kPatience)) << begun.output();
  begun.signal(SIGINT);
  expect_outcome(wait_to_end(begun), 0, {});
  save_ply(sphere_mesh(0.06f, 2), data_.mesh());
  expect_outcome(serve_once(), 2, {"session", "another mesh", "new --session folder"});
}

TEST_F(BadInput, APortInUse) {
  const std::string address = free_address();
  Process first(tracker({"run", "--source", "dataset:" + data_.folder.string(), "--endpoint", address}));
  ASSERT_TRUE(first.prints(" to " + address, kPatience)) << first.output();
  expect_outcome(track({}, address), 1, {address, "in use"});

  const int port = std::stoi(address.substr(address.rfind(':') + 1));
  expect_outcome(run_to_end(reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--headless",
                                           "--monitor-port", std::to_string(port)})),
                 1, {"monitor page", "port " + std::to_string(port), "choose another port"});
  EXPECT_FALSE(std::filesystem::exists(session_)) << "nothing was begun";
}

TEST_F(BadInput, AnAddressThatOthersReachWithoutKeys) {
  expect_outcome(track({}, "tcp://0.0.0.0:" + std::to_string(free_port())), 2,
                 {"0.0.0.0", "keys", "keygen", "127.0.0.1"});
  expect_outcome(serve_once({}, "tcp://192.0.2.1:7410"), 2, {"192.0.2.1", "keys", "keygen"});
}

TEST_F(BadInput, ACameraThatIsNotThere) {
  expect_outcome(run_to_end(tracker({"run", "--source", "aravis:127.0.0.77", "--endpoint", free_address()})), 1,
                 {"camera 127.0.0.77 does not answer", "sheen-tracker cameras"});
  expect_outcome(run_to_end(tracker({"run", "--source", "telepathy:7"})), 2, {"telepathy:7", "aravis:ID"});
}

TEST_F(BadInput, AMeshThatNoImageShows) {
  Mesh mesh = load_mesh(data_.mesh()).mesh;
  for (auto& vertex : mesh.vertices) vertex.x() += 5;  // metres: another frame
  save_ply(mesh, data_.mesh());
  expect_outcome(build(), 1, {"none of its 4 images shows the mesh", "same frame and units"});

  const std::string address = free_address();
  Process desk(serve(data_.mesh(), session_, {"--once", "--endpoint", address}));
  expect_outcome(track({}, address, "15"), 0, {});
  expect_outcome(wait_to_end(desk), 1, {"mesh.ply", "none of the session's 4 captures shows this mesh", "kept"});
  EXPECT_EQ(captures_of(session_).size(), 4u);
}

TEST_F(BadInput, WrongUsage) {
  for (const Words& words : std::vector<Words>{{"frobnicate"}, {}, {"build"}, {"build", "x", "--mesh", "y", "--frob"}})
    expect_outcome(run_to_end(reconstructor(words)), 2, {"--help"});
  for (const Words& words : std::vector<Words>{{"frobnicate"}, {}, {"run", "--frob"}, {"run", "--linger", "soon"}})
    expect_outcome(run_to_end(tracker(words)), 2, {"--help"});
  expect_outcome(run_to_end(tracker({"run"})), 2, {"--source"});
  for (const Words& command : {tracker({"--help"}), tracker({"run", "--help"}), reconstructor({"serve", "--help"})})
    expect_outcome(run_to_end(command), 0, {"--help"});
}

TEST_F(BadInput, NoDisplayForTheWindow) {
  const ProcessOptions no_display{.environment = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}}};
  expect_outcome(
      run_to_end(reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--no-monitor"}), no_display),
      1, {"no display", "--headless"});
}

}  // namespace
}  // namespace sheen::testing
