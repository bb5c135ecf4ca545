// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/base/errors.h"

namespace sheen {

inline constexpr int kSessionVersion = 2;  ///< of the layout on disk; a newer one is refused with both versions named

/// An entry of a session's list of withdrawals: a capture was taken back, or put back. The last entry of a capture
/// counts.
struct Withdrawal {
  std::uint64_t number = 0;  ///< of the entry, rising
  std::uint64_t capture = 0;
  bool withdrawn = false;
};

/// The index itself cannot be used: no database, or one whose tables are not as they must be. What it should hold can
/// be rebuilt from the capture files.
class DamagedIndex : public FileError {
 public:
  using FileError::FileError;
};

/// Another program keeps the session's index locked. What was asked for may be asked for again.
class SessionBusy : public FileError {
 public:
  using FileError::FileError;
};

/// A capture to be appended has the source session and the number of one that is there, and another image: two sources
/// go by one name.
class TakenName : public FileError {
 public:
  using FileError::FileError;
};

/// One capture cannot be read. The others can.
class DamagedCapture : public FileError {
 public:
  using FileError::FileError;
};

}  // namespace sheen
