// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace sheen {

/// Where a token is looked for when no file gives it.
inline constexpr const char* kMonitorTokenVariable = "SHEEN_MONITOR_TOKEN";

/// The page's token: what stands in `file`, or where that is empty in the environment variable SHEEN_MONITOR_TOKEN, or
/// none; never on a command line, where `ps` shows it. Throws ConfigError for a file that is empty or that everyone may
/// read; FileError for one that is not there.
std::string monitor_token(const std::filesystem::path& file);

}  // namespace sheen
