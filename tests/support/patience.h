// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen::testing {

#ifndef SHEEN_PATIENCE
#define SHEEN_PATIENCE 1
#endif

/// How many times slower a program may be than an ordinary build before a limit that is there for what hangs ends it:
/// tests/CMakeLists.txt sets it for sanitized builds, for ctest's own limits too. It never scales what a test measures.
inline constexpr int kPatienceFactor = SHEEN_PATIENCE;

}  // namespace sheen::testing
