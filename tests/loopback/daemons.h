// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/patience.h"
#include "tests/support/process.h"

namespace sheen::testing {

/// For what takes seconds on an idle machine: only what hangs is to be ended by it.
inline constexpr std::chrono::seconds kPatience{60 * kPatienceFactor};
/// Work on so many images takes long enough to be met in its middle; a sanitized program needs longer for each.
inline constexpr int kManyViews = kPatienceFactor == 1 ? 150 : 40;

using Words = std::vector<std::string>;
Words operator+(Words a, const Words& b);

Words tracker(const Words& arguments);  ///< command line of build/bin/sheen-tracker
/// `sheen-tracker run` that waits at its end as long as a test does: a sanitized reconstructor is slow to acknowledge.
Words patient_run(const Words& arguments);
Words reconstructor(const Words& arguments);  ///< and of build/bin/sheen-reconstructor

/// A link of 127.0.0.1 with CURVE: a free port, and a key pair per role in `folder`.
struct SecureLink {
  explicit SecureLink(const std::filesystem::path& folder);
  Words tracker_options() const;
  Words reconstructor_options() const;

  std::filesystem::path folder;
  std::string endpoint;
};
std::string free_address();  ///< tcp://127.0.0.1:PORT

/// serve without window and status page.
Words serve(const std::filesystem::path& mesh, const std::filesystem::path& session, const Words& more);

/// Runs to the end. Fails the test if it takes longer than `kPatience`.
struct Outcome {
  ProcessEnd end;
  std::string output;
};
Outcome run_to_end(const Words& command, const ProcessOptions& options = {});
Outcome wait_to_end(Process& process);

/// It must end with `status` and say all of `words`.
void expect_outcome(const Outcome& outcome, int status, const Words& words);

/// (source session, sequence) of every capture of a session, in its order; each is read and so checked.
std::vector<std::pair<std::string, std::uint64_t>> captures_of(const std::filesystem::path& session);
/// The number of captures so far, also while a daemon writes to it; 0 where there is no session yet.
std::uint64_t captures_so_far(const std::filesystem::path& session);
/// Whether there are `count` captures before `kPatience` is over.
bool wait_for_captures(const std::filesystem::path& session, std::uint64_t count);

/// Two saved models are the same to the bit: maps, mesh, and all of model.json but what it says about their origin.
void expect_same_model(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace sheen::testing
