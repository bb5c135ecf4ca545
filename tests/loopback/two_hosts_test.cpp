// SPDX-License-Identifier: Apache-2.0
// Two hosts: a process in a network namespace of its own, joined by a virtual cable, and in a time namespace in which
// the steady clock is three days ahead. What the receiver makes of the sender's times must be right to 2 ms.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>

#include "common/link/transport.h"
#include "tests/support/link.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

using namespace std::chrono_literals;

constexpr int kNewTimeNamespace = 0x80;  // CLONE_NEWTIME, which older headers lack
constexpr std::int64_t kAhead_s = 259'200;
constexpr double kTolerance_ns = 2e6;
enum Outcome { kRight = 0, kWrong = 1, kNoAnswer = 2, kNotPermitted = 77 };

std::int64_t now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool write_to(const char* file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  return out.good();
}

bool run(const std::string& command) {
  return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

/// The rights over namespaces of one's own, as root or as an ordinary user who may have them.
bool become_master_of_namespaces() {
  const std::string user = std::to_string(::getuid()), group = std::to_string(::getgid());
  if (::unshare(CLONE_NEWNET) == 0) return true;
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  write_to("/proc/self/setgroups", "deny");
  return write_to("/proc/self/uid_map", "0 " + user + " 1") && write_to("/proc/self/gid_map", "0 " + group + " 1");
}

pid_t spawn(const std::function<int()>& body) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::_exit(body());
}

int status_of(pid_t pid) {
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kWrong;
}

/// `body` in a process whose steady clock is ahead.
int with_clock_ahead(bool ahead, const std::function<int()>& body) {
  if (ahead && (::unshare(kNewTimeNamespace) != 0 ||
                !write_to("/proc/self/timens_offsets", "monotonic " + std::to_string(kAhead_s) + " 0\n")))
    return kNotPermitted;
  return status_of(spawn(body));
}

/// Both ends of the link, with keys: other machines can reach them.
struct TwoHosts {
  explicit TwoHosts(const std::filesystem::path& folder)
      : tracker(generate_keys(folder, "tracker")), desk(generate_keys(folder, "desk")), allowed(folder / "allowed") {
    std::ofstream(allowed) << desk.public_key << " reconstructor desk\n";
  }

  int send() const {
    SenderOptions options = sender_options("tcp://10.77.0.2:7410");
    options.keys = tracker;
    options.allowlist = allowed;
    CaptureSender sender(options);
    for (std::uint64_t sequence = 1;; ++sequence) {
      Capture capture = sample_capture("s", sequence);
      capture.times.grabbed_ns = now_ns();
      if (!sender.keep(capture, kLong)) return kNoAnswer;
      std::this_thread::sleep_for(20ms);
    }
  }

  /// Whether the sender's times are understood, of which those in truth are `ahead_ns` before ours.
  int receive(std::int64_t ahead_ns) const {
    ReceiverOptions options = receiver_options("tcp://10.77.0.2:7410");
    options.keys = desk;
    options.server_public_key = tracker.public_key;
    CaptureReceiver receiver(options);
    for (const auto end = std::chrono::steady_clock::now() + 30s; std::chrono::steady_clock::now() < end;) {
      const auto received = receiver.next(1s);
      if (!received) continue;
      receiver.acknowledge("s", received->capture.sequence);
      const std::optional<ClockOffset> clock = receiver.stats().clock;
      // A busy machine may hold up each of the first answers; what is known is never worse than half the round trip.
      if (!clock || static_cast<double>(clock->round_trip_ns) >= 2 * kTolerance_ns) continue;
      const std::int64_t at = now_ns(), grabbed = received->capture.times.grabbed_ns;
      const auto latency_ns = static_cast<double>(at + clock->offset_ns - grabbed);
      const auto true_latency_ns = static_cast<double>(at + ahead_ns - grabbed);
      return latency_ns > -kTolerance_ns && std::abs(latency_ns - true_latency_ns) <= kTolerance_ns ? kRight : kWrong;
    }
    return kNoAnswer;
  }

  CurveKeys tracker, desk;
  std::filesystem::path allowed;
};

/// Builds the two hosts and has them talk; ends in a process of its own.
int meet(const std::filesystem::path& folder, bool tracker_is_ahead) {
  if (!become_master_of_namespaces()) return kNotPermitted;
  const TwoHosts hosts(folder);
  int apart[2], joined[2];
  if (::pipe(apart) != 0 || ::pipe(joined) != 0) return kNotPermitted;
  const pid_t rig = spawn([&]() -> int {
    char go = ::unshare(CLONE_NEWNET) == 0 ? 1 : 0;
    if (::write(apart[1], &go, 1) != 1 || !go || ::read(joined[0], &go, 1) != 1) return kNotPermitted;
    if (!run("ip addr add 10.77.0.2/24 dev rig0 && ip link set rig0 up")) return kNotPermitted;
    return with_clock_ahead(tracker_is_ahead, [&] { return hosts.send(); });
  });
  char go = 0;
  if (::read(apart[0], &go, 1) != 1 || !go ||
      !run("ip link add desk0 type veth peer name rig0 netns " + std::to_string(rig)) ||
      !run("ip addr add 10.77.0.1/24 dev desk0 && ip link set desk0 up") || ::write(joined[1], &go, 1) != 1)
    return kNotPermitted;
  const std::int64_t ahead_ns = (tracker_is_ahead ? 1 : -1) * kAhead_s * 1'000'000'000;
  const int outcome = with_clock_ahead(!tracker_is_ahead, [&] { return hosts.receive(ahead_ns); });
  int status = 0;
  const bool rig_gave_up = ::waitpid(rig, &status, WNOHANG) == rig && WIFEXITED(status);
  if (outcome == kNoAnswer && rig_gave_up) return WEXITSTATUS(status);
  ::kill(rig, SIGKILL);
  ::waitpid(rig, nullptr, 0);
  return outcome;
}

class TwoHostsTest : public ::testing::TestWithParam<bool> {};

TEST_P(TwoHostsTest, WhoseClocksAreThreeDaysApartAgreeOnTheLatency) {
  const TempFolder temp;
  const int outcome = status_of(spawn([&] { return meet(temp.path(), GetParam()); }));
  if (outcome == kNotPermitted) GTEST_SKIP() << "network and time namespaces, or `ip`, are not to be had here";
  EXPECT_NE(outcome, kNoAnswer) << "no capture came with a clock known to 2 ms";
  EXPECT_EQ(outcome, kRight);
}

INSTANTIATE_TEST_SUITE_P(Ahead, TwoHostsTest, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "Tracker" : "Reconstructor"; });

}  // namespace
}  // namespace sheen::testing
