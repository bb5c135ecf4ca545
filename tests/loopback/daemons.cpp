// SPDX-License-Identifier: Apache-2.0
#include "tests/loopback/daemons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/link/transport.h"
#include "common/session/session.h"

namespace sheen::testing {

namespace fs = std::filesystem;

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Words tracker(const Words& arguments) {
  return Words{SHEEN_TRACKER} + arguments;
}

Words patient_run(const Words& arguments) {
  return tracker({"run", "--linger", std::to_string(kPatience.count())}) + arguments;
}

Words reconstructor(const Words& arguments) {
  return Words{SHEEN_RECONSTRUCTOR} + arguments;
}

std::string free_address() {
  return "tcp://127.0.0.1:" + std::to_string(free_port());
}

SecureLink::SecureLink(const fs::path& key_folder) : folder(key_folder), endpoint(free_address()) {
  generate_keys(folder, "tracker");
  const CurveKeys desk = generate_keys(folder, "desk");
  std::ofstream(folder / "allowed") << desk.public_key << " reconstructor desk\n";
}

Words SecureLink::tracker_options() const {
  return {"--endpoint", endpoint, "--keys", folder / "tracker.key", "--allow", folder / "allowed"};
}

Words SecureLink::reconstructor_options() const {
  return {"--endpoint", endpoint, "--keys", folder / "desk.key", "--tracker-key", folder / "tracker.pub"};
}

Words serve(const fs::path& mesh, const fs::path& session, const Words& more) {
  return reconstructor({"serve", "--mesh", mesh, "--session", session, "--headless", "--no-monitor", "--loss", "0dB"}) +
         more;
}

Outcome wait_to_end(Process& process) {
  const auto end = process.wait(kPatience);
  if (!end) ADD_FAILURE() << "still runs after " << kPatience.count() << " s:\n" << process.output();
  return {end.value_or(ProcessEnd{}), process.output()};
}

Outcome run_to_end(const Words& command, const ProcessOptions& options) {
  Process process(command, options);
  return wait_to_end(process);
}

void expect_outcome(const Outcome& outcome, int status, const Words& words) {
  EXPECT_EQ(outcome.end.signal, 0) << outcome.output;
  EXPECT_EQ(outcome.end.status, status) << outcome.output;
  for (const std::string& word : words) EXPECT_THAT(outcome.output, ::testing::HasSubstr(word));
}

std::vector<std::pair<std::string, std::uint64_t>> captures_of(const fs::path& folder) {
  const Session session = Session::open_read_only(folder);
  std::vector<std::pair<std::string, std::uint64_t>> captures;
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const Capture capture = session.read(i);
    captures.emplace_back(capture.source_session, capture.sequence);
  }
  return captures;
}

std::uint64_t captures_so_far(const fs::path& folder) {
  return Session::exists(folder) ? Session::open_read_only(folder).size() : 0;
}

bool wait_for_captures(const fs::path& session, std::uint64_t count) {
  for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;
       std::this_thread::sleep_for(std::chrono::milliseconds(5)))
    if (captures_so_far(session) >= count) return true;
  return false;
}

void expect_same_model(const fs::path& a, const fs::path& b) {
  // Not EXPECT_EQ: megabytes of binary differences help nobody.
  for (const char* file : {"maps.exr", "mesh.ply"}) EXPECT_TRUE(read_file(a / file) == read_file(b / file)) << file;
  const auto description = [](const fs::path& folder) {
    auto json = nlohmann::json::parse(read_file(folder / "model.json"));
    EXPECT_GT(json.at("patches").at("patch").size(), 0u);
    json.erase("metadata");
    return json;
  };
  const auto in_a = description(a), in_b = description(b);
  for (const auto& [key, value] : in_a.items()) EXPECT_TRUE(in_b.contains(key) && value == in_b[key]) << key;
  EXPECT_EQ(in_a.size(), in_b.size());
}

}  // namespace sheen::testing
