// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sheen {

enum class Finding : std::uint8_t { kOk, kWarn, kFail };
const char* to_string(Finding finding);  ///< "OK", "WARN", "FAIL"

/// One thing that a `doctor` command has looked at.
struct SetupCheck {
  std::string name;
  Finding finding = Finding::kOk;
  std::string text;  ///< what was found, and what to do about it
};

/// Whether something loads. `load` returns what to say of it; the Error that it throws, with the remedy behind it, is
/// the finding.
SetupCheck check_loading(const std::string& name, const std::function<std::string()>& load,
                         const std::string& remedy = {});

/// Prints one line per check, or all as JSON, on standard output. Throws Error when a check has failed.
void report_checks(const std::vector<SetupCheck>& checks, bool json);

}  // namespace sheen
