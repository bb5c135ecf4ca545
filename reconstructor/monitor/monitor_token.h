// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace sheen {

/// Where a token is looked for when neither an option nor a file gives it.
inline constexpr const char* kMonitorTokenVariable = "SHEEN_MONITOR_TOKEN";

/// The page's token: `given`, or what stands in `file` (where `ps` shows it to nobody), or in the environment variable
/// SHEEN_MONITOR_TOKEN, or none. Throws ConfigError where both are given, and for a file that is empty or that everyone
/// may read; FileError for one that is not there.
std::string monitor_token(const std::string& given, const std::filesystem::path& file);

}  // namespace sheen
