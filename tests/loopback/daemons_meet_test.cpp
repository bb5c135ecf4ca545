// SPDX-License-Identifier: Apache-2.0
// What two daemons do when the other one is away, refuses them, or when the disk is full or the person has enough.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <fstream>

#include "common/link/transport.h"
#include "common/session/session.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kStopPatience{5};  ///< a second is asked for; machines that run tests are slow

class DaemonsMeet : public ::testing::Test {
 protected:
  explicit DaemonsMeet(int views = 6, int width = 160)
      : data_{.folder = temp_.path() / "data", .views = views, .width = width, .height = width * 3 / 4} {
    data_.write();
  }

  Words track(const Words& more) { return patient_run({"--source", "dataset:" + data_.folder.string()}) + more; }
  Words desk(const Words& more) { return serve(data_.mesh(), session_, more); }
  void expect_all_captures() {
    std::vector<std::uint64_t> sequences, all;
    for (const auto& [source, sequence] : captures_of(session_)) sequences.push_back(sequence);
    for (int i = 1; i <= data_.views; ++i) all.push_back(static_cast<std::uint64_t>(i));
    EXPECT_EQ(sequences, all);
  }
  /// SIGINT, and the end that follows.
  static void expect_stops(Process& process, const Words& words, std::chrono::seconds patience = kStopPatience,
                           int status = 0) {
    process.signal(SIGINT);
    const auto end = process.wait(patience);
    ASSERT_TRUE(end) << "still runs after Ctrl-C:\n" << process.output();
    expect_outcome({*end, process.output()}, status, words);
  }

  const TempFolder temp_;
  const BallDataset data_;
  const std::filesystem::path session_ = temp_.path() / "session";
};

TEST_F(DaemonsMeet, CtrlCEndsAReconstructorThatSawNoTracker) {
  Process waiting(desk({"--endpoint", free_address()}));
  ASSERT_TRUE(waiting.prints("waiting for a tracker", kPatience)) << waiting.output();
  expect_stops(waiting, {"captures=0"});
  EXPECT_EQ(captures_of(session_).size(), 0u);
}

/// The socket on which systemd hears of its services.
class ServiceManager {
 public:
  explicit ServiceManager(const std::filesystem::path& path) : path_(path) {
    sockaddr_un address{.sun_family = AF_UNIX};
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    const timeval patience{.tv_sec = kPatience.count()};
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0)
      ADD_FAILURE() << path << ": " << std::strerror(errno);
  }
  ~ServiceManager() { close(socket_); }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  ProcessOptions service() const { return {.environment = {{"NOTIFY_SOCKET", path_.string()}}}; }
  /// The next message; empty after `kPatience`.
  std::string hears() const {
    char text[256];
    const ssize_t length = recv(socket_, text, sizeof text, 0);
    return length > 0 ? std::string(text, static_cast<std::size_t>(length)) : "";
  }

 private:
  std::filesystem::path path_;
  int socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(DaemonsMeet, TheServiceManagerIsToldWhenBothAreReadyAndWhenTheyEnd) {
  const std::string address = free_address();
  const ServiceManager of_the_rig(temp_.path() / "rig.notify"), of_the_desk(temp_.path() / "desk.notify");
  Process rig(track({"--endpoint", address}), of_the_rig.service());
  EXPECT_EQ(of_the_rig.hears(), "READY=1");
  Process keeping(desk({"--endpoint", address}), of_the_desk.service());
  EXPECT_EQ(of_the_desk.hears(), "READY=1");
  EXPECT_EQ(of_the_rig.hears(), "STOPPING=1");
  expect_outcome(wait_to_end(rig), 0, {"6 keyframes sent"});
  keeping.signal(SIGTERM);
  EXPECT_EQ(of_the_desk.hears(), "STOPPING=1");
  expect_outcome(wait_to_end(keeping), 0, {"the model is saved"});
}

TEST_F(DaemonsMeet, ATrackerWithoutAReconstructorSaysThatNothingIsSafe) {
  const std::string address = free_address();
  const Words run = tracker({"run", "--source", "dataset:" + data_.folder.string(), "--linger", "0.2"});
  expect_outcome(run_to_end(run + Words{"--endpoint", address}), 1,
                 {"6 keyframes were not acknowledged", "reconstructor", address});
  Process waiting(track({"--endpoint", address}));
  ASSERT_TRUE(waiting.prints(address, kPatience));
  std::this_thread::sleep_for(milliseconds(300));
  expect_stops(waiting, {"keyframes were not acknowledged"}, kStopPatience, 1);
}

TEST_F(DaemonsMeet, TheReconstructorMayComeLastAndCtrlCFinishesTheModel) {
  const std::string address = free_address();
  Process rig(track({"--endpoint", address}));
  ASSERT_TRUE(rig.prints(address, kPatience));
  Process keeping(desk({"--endpoint", address}));
  expect_outcome(wait_to_end(rig), 0, {"6 keyframes sent"});
  expect_stops(keeping, {"the model is saved"}, kPatience);
  expect_all_captures();
}

TEST_F(DaemonsMeet, CtrlCWaitsForADeskThatStoresSlowly) {
  const std::string address = free_address();
  Process rig(track({"--endpoint", address}));
  CaptureReceiver slow({.endpoint = address});
  const auto store = [&](const Received& one) { slow.acknowledge(one.capture.source_session, one.capture.sequence); };
  const auto first = slow.next(kPatience);
  ASSERT_TRUE(first) << rig.output();
  store(*first);
  const auto second = slow.next(kPatience);
  ASSERT_TRUE(second) << rig.output();
  rig.signal(SIGINT);
  ASSERT_TRUE(rig.prints("Ctrl-C again gives them up", kPatience)) << rig.output();
  store(*second);
  while (!slow.stats().ended)
    if (const auto next = slow.next(milliseconds(100))) store(*next);
  expect_outcome(wait_to_end(rig), 0, {"keyframes sent"});
}

TEST_F(DaemonsMeet, AKeyThatIsNotAllowedGetsNothingAndIsTold) {
  const SecureLink link(temp_.path());
  std::ofstream(temp_.path() / "allowed", std::ios::trunc)
      << generate_keys(temp_.path(), "stranger").public_key << " reconstructor stranger\n";
  Process rig(track(link.tracker_options()));
  Process refused(desk(link.reconstructor_options() + Words{"--once"}));
  EXPECT_TRUE(rig.prints("refused: key", kPatience)) << rig.output();
  EXPECT_TRUE(refused.prints("refused this key", kPatience)) << refused.output();
  EXPECT_THAT(refused.output(), ::testing::HasSubstr("allowlist"));
  EXPECT_EQ(captures_so_far(session_), 0u);
  expect_stops(refused, {});
  expect_stops(rig, {"6 keyframes were not acknowledged", "last refusal", "key"}, kStopPatience, 1);
}

TEST_F(DaemonsMeet, ASecondReconstructorIsToldWhyItGetsNothing) {
  const std::string address = free_address();
  CaptureReceiver first({.endpoint = address});
  Process rig(track({"--endpoint", address}));
  ASSERT_TRUE(first.next(kPatience)) << rig.output();  // not acknowledged: the tracker stays
  Process second(desk({"--endpoint", address}));
  EXPECT_TRUE(second.prints("busy: another receiver", kPatience)) << second.output();
  EXPECT_EQ(captures_so_far(session_), 0u);
}

TEST_F(DaemonsMeet, AFileSystemWithoutRoomNamesTheRemedy) {
  const auto small = temp_.path() / "small";
  std::filesystem::create_directories(small);
  const std::string mount = "mount -t tmpfs -o size=128k tmpfs '" + small.string() + "' && ";
  if (run_to_end({"unshare", "-rm", "sh", "-c", mount + "true"}).end.status != 0)
    GTEST_SKIP() << "this machine lets nobody mount a small file system";
  const std::string address = free_address();
  Process rig(track({"--endpoint", address}));
  const Words command = serve(data_.mesh(), small / "session", {"--endpoint", address});
  std::string quoted;
  for (const std::string& word : command) quoted += "'" + word + "' ";
  expect_outcome(run_to_end({"unshare", "-rm", "sh", "-c", mount + "exec " + quoted}), 1,
                 {"cannot be written", "No space left", "make room"});
}

TEST_F(DaemonsMeet, AModelThatDoesNotFitOnTheDisk) {
  const Words build = reconstructor({"build", data_.folder, "--mesh", data_.mesh()});
  expect_outcome(run_to_end(build + Words{"--out", temp_.path() / "model", "--loss", "0dB"}, {.file_bytes = 30000}), 1,
                 {"maps.exr", "cannot be written"});
  EXPECT_FALSE(std::filesystem::exists(temp_.path() / "model" / "model.json"));
  expect_outcome(run_to_end(build + Words{"--json", "/dev/full"}), 1, {"/dev/full: cannot be written"});
}

TEST_F(DaemonsMeet, ACaptureOutlivesItsDisplay) {
  // Nothing but the number that it found free: it also tells of those that are taken.
  Process display({"/bin/sh", "-c", "exec Xvfb -displayfd 1 -screen 0 1280x1024x24 -nolisten tcp 2> /dev/null"});
  if (!display.prints("\n", kPatience)) GTEST_SKIP() << "no Xvfb here";
  const std::string number = display.output().substr(0, display.output().find('\n'));
  const std::string address = free_address();
  Process watched(reconstructor({"serve", "--mesh", data_.mesh(), "--session", session_, "--no-monitor", "--once",
                                 "--endpoint", address}),
                  {.environment = {{"DISPLAY", ":" + number}, {"LIBGL_ALWAYS_SOFTWARE", "1"}}});
  ASSERT_TRUE(watched.prints("waiting for a tracker", kPatience)) << watched.output();
  display.kill();
  EXPECT_TRUE(watched.prints("the capture continues without it: the display has gone away", kPatience))
      << watched.output();
  expect_outcome(run_to_end(track({"--endpoint", address})), 0, {"6 keyframes sent"});
  expect_outcome(wait_to_end(watched), 0, {"images added to the model"});
  expect_all_captures();
}

class LargeImages : public DaemonsMeet {
 protected:
  LargeImages() : DaemonsMeet(6, 400) {}
};

TEST_F(LargeImages, AFullDiskEndsTheCaptureClearlyAndItGoesOnWithRoom) {
  const std::string address = free_address();
  Process rig(track({"--endpoint", address}));
  expect_outcome(run_to_end(desk({"--endpoint", address}), {.file_bytes = 65536}), 1,
                 {"captures/incoming.part: cannot be written"});
  EXPECT_LT(captures_of(session_).size(), 6u);
  EXPECT_TRUE(rig.running()) << "it has nobody to give its captures to, but they are not lost";
  Process again(desk({"--endpoint", address, "--once"}));
  expect_outcome(wait_to_end(again), 0, {"images added to the model"});
  expect_outcome(wait_to_end(rig), 0, {"6 keyframes sent"});
  expect_all_captures();
}

class ManyViews : public DaemonsMeet {
 protected:
  ManyViews() : DaemonsMeet(kManyViews) {}
};

TEST_F(ManyViews, CtrlCInTheMiddleLeavesASessionThatGoesOn) {
  const std::string address = free_address();
  Process rig(track({"--endpoint", address}));
  Process first(desk({"--endpoint", address}));
  while (first.running() && captures_so_far(session_) == 0) std::this_thread::sleep_for(milliseconds(1));
  expect_stops(first, {}, kPatience);
  EXPECT_TRUE(rig.running()) << "too early for a test of the middle:\n" << rig.output();
  Process second(desk({"--endpoint", address, "--once"}));
  expect_outcome(wait_to_end(second), 0, {"images added to the model"});
  expect_outcome(wait_to_end(rig), 0, {std::to_string(kManyViews) + " keyframes sent"});
  expect_all_captures();
}

TEST_F(ManyViews, CtrlCInTheMiddleEndsATrackerWhichThenGoesOn) {
  const std::string address = free_address();
  Process keeping(desk({"--endpoint", address}));
  Process rig(track({"--endpoint", address}));
  while (rig.running() && captures_so_far(session_) == 0) std::this_thread::sleep_for(milliseconds(1));
  rig.signal(SIGINT);
  const auto end = rig.wait(kPatience);  // while keyframes are stored it waits for the next
  ASSERT_TRUE(end) << "still runs after Ctrl-C:\n" << rig.output();
  const bool all_safe = rig.output().find("were not acknowledged") == std::string::npos;  // what was under way is not
  expect_outcome({*end, rig.output()}, all_safe ? 0 : 1, {"keyframes sent"});
  expect_outcome(run_to_end(track({"--endpoint", address})), 0, {std::to_string(kManyViews) + " keyframes sent"});
  expect_stops(keeping, {"captures=" + std::to_string(kManyViews)}, kPatience);
  expect_all_captures();
}

TEST_F(ManyViews, CtrlCEndsABuildWithoutAModel) {
  const auto out = temp_.path() / "model";
  Process build(reconstructor({"build", data_.folder, "--mesh", data_.mesh(), "--out", out}));
  ASSERT_TRUE(build.prints("images", kPatience)) << build.output();
  build.signal(SIGINT);
  const auto end = build.wait(kStopPatience);
  ASSERT_TRUE(end) << build.output();
  expect_outcome({*end, build.output()}, 1, {"stopped", "no model was written"});
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace sheen::testing
