// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sheen {

enum class LogLevel : std::uint8_t { kInfo, kWarning, kError };

/// A name and a value beside a message, for programs: {"sequence", 12}.
struct LogField {
  template <std::integral T>
  LogField(std::string_view k, T v) : key(k), value(static_cast<std::int64_t>(v)) {}
  LogField(std::string_view k, bool v) : key(k), value(v) {}
  LogField(std::string_view k, double v) : key(k), value(v) {}
  LogField(std::string_view k, std::string_view v) : key(k), value(std::string(v)) {}
  LogField(std::string_view k, const char* v) : key(k), value(std::string(v)) {}
  LogField(std::string_view k, const std::string& v) : key(k), value(v) {}

  std::string key;
  std::variant<bool, std::int64_t, double, std::string> value;
};
using LogFields = std::vector<LogField>;

struct LogOptions {
  bool json = false;           ///< one JSON object per line instead of text
  std::filesystem::path file;  ///< appended to; empty: standard error
  std::size_t queue =
      2048;  ///< records that wait for a slow terminal or disk; then the oldest are dropped, and counted
};

/// Starts the thread that writes. Before, and after `stop_logging`, records go nowhere. Throws FileError.
void start_logging(const LogOptions& options);
/// Writes what waits. A program calls it once, at its end.
void stop_logging();

/// Never waits and never throws, so that it may be called while frames are coming in. `component` is the part of the
/// program that speaks ("link", "journal", ...).
void log(LogLevel level, std::string_view component, std::string_view message, const LogFields& fields = {}) noexcept;
inline void log_info(std::string_view component, std::string_view message, const LogFields& fields = {}) noexcept {
  log(LogLevel::kInfo, component, message, fields);
}
inline void log_warning(std::string_view component, std::string_view message, const LogFields& fields = {}) noexcept {
  log(LogLevel::kWarning, component, message, fields);
}
inline void log_error(std::string_view component, std::string_view message, const LogFields& fields = {}) noexcept {
  log(LogLevel::kError, component, message, fields);
}

/// Records dropped since `start_logging` because nobody wrote them fast enough.
std::uint64_t log_records_dropped();

/// One record as it is written. Bytes that could forge another record or a terminal's control sequence are escaped.
std::string format_log_text(std::string_view time, LogLevel level, std::string_view component, std::string_view message,
                            const LogFields& fields);
std::string format_log_json(std::string_view time, LogLevel level, std::string_view component, std::string_view message,
                            const LogFields& fields);

}  // namespace sheen
