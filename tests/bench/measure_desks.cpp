// SPDX-License-Identifier: Apache-2.0
//
// Measures what it takes to show a growing model to others: `deploy/measure desks [--json FILE]`. The simulated rig's
// images go to `serve` as fast as it adds them to the model: no desk, four that turn the model in their hands, one that
// takes no answer; in turn, since a machine's other work comes and goes.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "tests/bench/goal_rows.h"
#include "tests/bench/model_desk.h"
#include "tests/bench/process_state.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using testing::Process;
using Clock = std::chrono::steady_clock;

constexpr int kRounds = 4, kDesks = 4;
constexpr std::chrono::seconds kPatience{120};

struct Watchers {
  int desks = 0;
  bool stalled = false;
};

struct Watched {
  double images_per_s = 0;
  double of_machine = 0, of_process = 0;  ///< what the thread had that answers desks, of all processors' time
  std::vector<double> lags_ms;
  double megabytes = 0;  ///< to all desks
};

/// Of the simulated rig, which deploy/measure renders: a data set with its mesh.
std::filesystem::path rig() {
  const char* const folder = std::getenv("SHEEN_RIG");
  if (!folder) throw ConfigError("set SHEEN_RIG to a folder that `sheen-tracker simulate --out` has written");
  return folder;
}

/// Of a process, and of its thread that answers desks.
struct ProcessorTime {
  double all_s = 0, http_s = 0;
};

ProcessorTime processor_time(pid_t process) {
  const std::filesystem::path folder = "/proc/" + std::to_string(process);
  ProcessorTime time{.all_s = processor_seconds(process)};
  for (const auto& thread : std::filesystem::directory_iterator(folder / "task")) {
    std::string name;
    std::ifstream(thread.path() / "comm") >> name;
    if (name == "http") time.http_s += processor_seconds(thread.path() / "stat");
  }
  return time;
}

template <typename Happened>
void wait_for(const std::string& what, const Happened& happened) {
  for (const auto begin = Clock::now(); !happened(); std::this_thread::sleep_for(milliseconds(10)))
    if (Clock::now() - begin > kPatience) throw Error("waited in vain for " + what);
}

Watched capture(const std::filesystem::path& rig, const Watchers& watchers) {
  const TempFolder folder;
  const std::string endpoint = testing::free_address();
  const int port = testing::free_port();
  Process desk(testing::reconstructor({"serve", "--mesh", rig / "mesh.ply", "--session", folder.path() / "session",
                                       "--endpoint", endpoint, "--headless", "--once", "--loss", "0dB",
                                       "--monitor-port", std::to_string(port)}));
  const auto says = [&desk](const std::string& words) { return desk.output().find(words) != std::string::npos; };
  wait_for("the page", [&] { return says("watch at"); });
  wait_for("the link", [&] { return says("waiting for a tracker"); });
  std::vector<std::unique_ptr<ModelDesk>> desks;
  for (int i = 0; i < watchers.desks; ++i) desks.push_back(std::make_unique<ModelDesk>(port, 1.5 * i));
  std::unique_ptr<StalledDesk> stalled;
  if (watchers.stalled) stalled = std::make_unique<StalledDesk>(port);
  std::this_thread::sleep_for(milliseconds(500));  // they have the mesh

  const ProcessorTime before = processor_time(desk.id());
  Process tracker(testing::tracker({"run", "--source", "dataset:" + rig.string(), "--endpoint", endpoint}));
  wait_for("the tracker", [&] { return says("connected to the tracker"); });
  const auto begun = Clock::now();
  wait_for("the capture's end", [&] { return says("finishing"); });
  const std::chrono::duration<double> took = Clock::now() - begun;
  const ProcessorTime after = processor_time(desk.id());
  Watched watched;
  watched.images_per_s = static_cast<double>(testing::captures_so_far(folder.path() / "session")) / took.count();
  const double http_s = after.http_s - before.http_s;
  watched.of_machine = http_s / (took.count() * std::max(1u, std::thread::hardware_concurrency()));
  watched.of_process = http_s / (after.all_s - before.all_s);
  for (const auto& each : desks) {
    const std::vector<double> lags = each->lags_ms();
    watched.lags_ms.insert(watched.lags_ms.end(), lags.begin(), lags.end());
    watched.megabytes += 1e-6 * static_cast<double>(each->bytes());
  }
  desk.kill();
  return watched;
}

void measure(GoalReport& report) {
  std::vector<double> lags_ms, rates, ratios, stalled_ratios, shares, of_process, stalled_shares, megabytes;
  for (int round = 0; round < kRounds; ++round) {
    const Watched alone = capture(rig(), {}), watched = capture(rig(), {.desks = kDesks}),
                  stalled = capture(rig(), {.stalled = true});
    lags_ms.insert(lags_ms.end(), watched.lags_ms.begin(), watched.lags_ms.end());
    rates.push_back(alone.images_per_s);
    ratios.push_back(watched.images_per_s / alone.images_per_s);
    stalled_ratios.push_back(stalled.images_per_s / alone.images_per_s);
    shares.push_back(100 * watched.of_machine);
    of_process.push_back(100 * watched.of_process);
    stalled_shares.push_back(100 * stalled.of_machine);
    megabytes.push_back(watched.megabytes);
  }
  const auto median = [](const std::vector<double>& values) { return quantile(values, 0.5); };
  report.add(at_most(1000, {}, "from a snapshot to each of four desks that turn, p95", quantile(lags_ms, 0.95), "ms",
                     {{"median", median(lags_ms)},
                      {"snapshots times desks", lags_ms.size()},
                      {"MB to all desks", median(megabytes)}}));
  report.add(
      at_most(3, {}, "four desks: of all processors' time", median(shares), "%", {{"of serve's", median(of_process)}}));
  report.add(at_least(
      0.97, {}, "four desks: images/s over those without", median(ratios), "ratio",
      {{"images/s without", median(rates)}, {"lowest", quantile(ratios, 0)}, {"highest", quantile(ratios, 1)}}));
  report.add(at_most(0.5, {}, "a stalled desk: of all processors' time", median(stalled_shares), "%"));
  report.add(at_least(0.97, {}, "a stalled desk: images/s over those without", median(stalled_ratios), "ratio",
                      {{"lowest", quantile(stalled_ratios, 0)}, {"highest", quantile(stalled_ratios, 1)}}));
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  return sheen::measure_goals(argc, argv, "Measures what it takes to show a growing model to others.", sheen::measure);
}
