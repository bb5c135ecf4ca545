// SPDX-License-Identifier: Apache-2.0
// kill -9 of either daemon at any moment: restarted, they go on, and nothing that was acknowledged is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <random>
#include <thread>

#include "common/datasets/dataset.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

/// `attack --kills N` wants more than ctest does, and ctest fewer of sanitized programs.
int wanted_kills() {
  const char* wanted = std::getenv("SHEEN_ATTACK_KILLS");
  return wanted ? std::max(std::atoi(wanted), 1) : kPatienceFactor == 1 ? 20 : 6;
}

const int kKills = wanted_kills();
const int kLeastMidStream = kKills / 3;  ///< of the kills, with some captures in the session and others still to come
const int kLeastOfEach = kKills / 4;     ///< of the kills, for each daemon
constexpr std::uint64_t kViews = 60;
constexpr unsigned kSeed = 20;

/// Both daemons over one data set and one session, until both have ended by themselves.
class Capturing {
 public:
  Capturing(const BallDataset& data, const SecureLink& link, const std::filesystem::path& session)
      : tracker_command_(patient_run({"--source", "dataset:" + data.folder.string()}) + link.tracker_options()),
        serve_command_(
            serve(data.mesh(), session, link.reconstructor_options() + Words{"--once", "--config", data.scene()})) {
    rig_ = std::make_unique<Process>(tracker_command_);
    desk_ = std::make_unique<Process>(serve_command_);
  }

  /// As a supervisor would: whoever was killed is started again. A tracker that has ended is wanted again if the
  /// reconstructor was killed before it had seen the end.
  void keep_running() {
    restart_if_killed(rig_, tracker_command_);
    restart_if_killed(desk_, serve_command_);
    if (!rig_->running() && desk_->running() && Clock::now() - rig_ended_ > milliseconds(1500)) {
      rig_ = std::make_unique<Process>(tracker_command_);
      rig_ended_ = Clock::now();
    }
    if (rig_->running()) rig_ended_ = Clock::now();
  }
  bool finished() { return !desk_->running(); }
  void kill_tracker() { rig_->kill(); }
  void kill_reconstructor() { desk_->kill(); }

  /// The reconstructor must end well. A tracker that was started once more for nobody ends when it is told to, and says
  /// that nobody took its keyframes.
  void finish() {
    for (const auto deadline = Clock::now() + kPatience; !finished() && Clock::now() < deadline;) {
      keep_running();
      std::this_thread::sleep_for(milliseconds(10));
    }
    expect_outcome(wait_to_end(*desk_), 0, {"images added to the model"});
    if (!rig_->wait(seconds(3))) rig_->signal(SIGINT);  // even a slow start has come to its signal handler by then
    const Outcome rig = wait_to_end(*rig_);
    const bool taken = rig.output.find("were not acknowledged") == std::string::npos;
    expect_outcome(rig, taken ? 0 : 1, {"keyframes sent"});
  }

 private:
  static void restart_if_killed(std::unique_ptr<Process>& process, const Words& command) {
    if (const auto end = process->wait(milliseconds(0)); end && end->signal == SIGKILL)
      process = std::make_unique<Process>(command);
  }

  Words tracker_command_, serve_command_;
  std::unique_ptr<Process> rig_, desk_;
  Clock::time_point rig_ended_ = Clock::now();
};

class Moments {
 public:
  /// Waits for a random moment: soon after a start, or with a random number of captures kept, all of them included.
  /// False when the run was over before it came.
  bool wait(Capturing& capturing, const std::filesystem::path& session) {
    const bool start_up = pick(0, 3) == 0;
    const auto kept = start_up ? 0 : captures_so_far(session) + std::uint64_t(pick(1, kViews / 3));
    while (captures_so_far(session) < std::min(kept, kViews)) {
      capturing.keep_running();
      if (capturing.finished()) return false;
      std::this_thread::sleep_for(milliseconds(1));
    }
    const bool ending = kept >= kViews;
    for (const auto end = Clock::now() + milliseconds(pick(0, start_up || ending ? 250 : 10)); Clock::now() < end;
         std::this_thread::sleep_for(milliseconds(2)))
      if (capturing.keep_running(); capturing.finished()) return false;
    return true;
  }
  bool pick_tracker() { return pick(0, 1) == 0; }

 private:
  int pick(int first, int last) { return std::uniform_int_distribution(first, last)(random_); }

  std::mt19937 random_{kSeed};
};

struct Kills {
  int start_up = 0, mid_stream = 0, ending = 0, tracker = 0, reconstructor = 0;
  int all() const { return start_up + mid_stream + ending; }
};

TEST(Killed, AtRandomMomentsNothingIsLostAndTheModelIsTheSame) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data", .views = kViews, .width = 400, .height = 300};
  data.write();
  const auto built = temp.path() / "built";
  expect_outcome(run_to_end(reconstructor({"build", data.folder, "--mesh", data.mesh(), "--config", data.scene(),
                                           "--out", built, "--loss", "0dB"})),
                 0, {});
  std::vector<std::pair<std::string, std::uint64_t>> all;
  const std::string source = "dataset:" + load_dataset(data.folder).hash;
  for (std::uint64_t i = 1; i <= kViews; ++i) all.emplace_back(source, i);

  const SecureLink link(temp.path());
  std::cout << "seed " << kSeed << '\n';
  Moments moments;
  Kills kills;
  for (int run = 0; kills.all() < kKills; ++run) {
    const auto session = temp.path() / ("session" + std::to_string(run));
    Capturing capturing(data, link, session);
    for (std::uint64_t before = 0; before < kViews && kills.all() < kKills && moments.wait(capturing, session);) {
      before = captures_so_far(session);
      const bool tracker_dies = moments.pick_tracker();
      tracker_dies ? capturing.kill_tracker() : capturing.kill_reconstructor();
      ++(before == 0 ? kills.start_up : before < kViews ? kills.mid_stream : kills.ending);
      ++(tracker_dies ? kills.tracker : kills.reconstructor);
      std::cout << "run " << run << ": kill -9 of the " << (tracker_dies ? "tracker" : "reconstructor") << " with "
                << before << " of " << kViews << " captures kept\n";
      EXPECT_GE(captures_so_far(session), before) << "what was kept is gone";
      capturing.keep_running();
    }
    capturing.finish();
    EXPECT_EQ(captures_of(session), all) << "run " << run;
    expect_same_model(built, session / "model");
    if (HasFailure()) return;
  }
  EXPECT_GE(kills.mid_stream, kLeastMidStream);
  EXPECT_GE(kills.tracker, kLeastOfEach);
  EXPECT_GE(kills.reconstructor, kLeastOfEach);
}

}  // namespace
}  // namespace sheen::testing
