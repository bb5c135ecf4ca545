// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// Now, as ISO 8601 has it: "2026-11-28T12:03:04.567Z".
std::string utc_now();

}  // namespace sheen
