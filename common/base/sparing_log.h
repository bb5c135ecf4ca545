// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace sheen {

/// Warnings of what may happen many times per second, or that strangers cause: each subject is told at once, and again
/// at most once per minute, and no more than 256 of them, so that nobody fills the disk. Thread-safe.
class SparingLog {
 public:
  explicit SparingLog(std::string component) : component_(std::move(component)) {}
  /// `subject`: a key, an address, the kind of fault. Whether it was told.
  bool tell(const std::string& subject, std::string_view message);

 private:
  const std::string component_;
  std::mutex mutex_;
  std::map<std::string, std::chrono::steady_clock::time_point> told_;
};

}  // namespace sheen
