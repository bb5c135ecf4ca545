// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/setup_check.h"

namespace sheen {

// Each looks at one part of a reconstructor's setup and never throws for what it finds.
std::vector<SetupCheck> check_mesh(const std::filesystem::path& mesh);
SetupCheck check_secret_key(const std::filesystem::path& key_file);
SetupCheck check_public_key(const std::filesystem::path& pub_file);
/// Connects to "tcp://HOST:PORT" and hangs up.
SetupCheck check_endpoint(const std::string& endpoint, bool has_keys, std::chrono::milliseconds timeout);
/// An existing session must open; a new one must be possible. Room on the disk in both cases.
std::vector<SetupCheck> check_session(const std::filesystem::path& folder);
SetupCheck check_monitor_port(int port);
SetupCheck check_display();
SetupCheck check_processor();
/// The factorization of patches put to its extremes, as this program was compiled: a line for each.
std::vector<SetupCheck> check_numerics();

}  // namespace sheen
