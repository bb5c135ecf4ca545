// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// What `printf` would print, of any length; the compiler checks the values against the pattern.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace sheen
