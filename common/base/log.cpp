// SPDX-License-Identifier: Apache-2.0
#include "common/base/log.h"

#include <spdlog/async.h>
#include <spdlog/async_logger.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/utc_time.h"

namespace sheen {
namespace {

struct Logger {
  std::shared_ptr<spdlog::details::thread_pool> writer;
  std::shared_ptr<spdlog::async_logger> front;
  bool json = false;
};

std::mutex mutex;
std::shared_ptr<const Logger> current;

std::shared_ptr<const Logger> current_logger() {
  const std::lock_guard lock(mutex);
  return current;
}

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      break;
  }
  return spdlog::level::err;
}

const char* name(LogLevel level) {
  switch (level) {
    case LogLevel::kInfo:
      return "info";
    case LogLevel::kWarning:
      return "warning";
    case LogLevel::kError:
      break;
  }
  return "error";
}

/// Standard error, where a progress bar may stand.
class TerminalSink : public spdlog::sinks::stderr_color_sink_mt {
 public:
  void log(const spdlog::details::log_msg& record) override {
    const ProgressPause pause;
    spdlog::sinks::stderr_color_sink_mt::log(record);
  }
};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      out += c;
      continue;
    }
    std::array<char, 8> hex{};
    std::snprintf(hex.data(), hex.size(), "\\x%02x", byte);
    out += hex.data();
  }
  return out;
}

std::string as_text(const LogField& field) {
  if (const auto* flag = std::get_if<bool>(&field.value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&field.value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&field.value)) {
    std::array<char, 40> digits{};
    std::snprintf(digits.data(), digits.size(), "%.6g", *number);
    return digits.data();
  }
  const std::string value = escaped(std::get<std::string>(field.value));
  return value.find_first_of(" =\"") == std::string::npos && !value.empty()
             ? value
             : nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::ordered_json as_json(const LogField& field) {
  return std::visit(
      [](const auto& value) -> nlohmann::ordered_json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
          if (!std::isfinite(value)) return nullptr;
        return value;
      },
      field.value);
}

}  // namespace

void start_logging(const LogOptions& options) {
  auto logger = std::make_shared<Logger>();
  spdlog::sink_ptr sink;
  try {
    if (options.file.empty()) {
      auto terminal = std::make_shared<TerminalSink>();
      terminal->set_color(spdlog::level::info, "");
      sink = terminal;
    } else {
      sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(options.file.string());
    }
  } catch (const spdlog::spdlog_ex& error) {
    throw FileError(options.file.string(), std::string("cannot be written: ") + error.what());
  }
  sink->set_pattern("%^%v%$");
  logger->json = options.json;
  logger->writer = std::make_shared<spdlog::details::thread_pool>(options.queue, 1);
  logger->front = std::make_shared<spdlog::async_logger>("sheen", sink, logger->writer,
                                                         spdlog::async_overflow_policy::overrun_oldest);
  logger->front->flush_on(spdlog::level::warn);
  // What the writer meets (a full disk, a closed terminal) must not come back as an exception or as more output.
  logger->front->set_error_handler([](const std::string&) {});
  const std::lock_guard lock(mutex);
  current = std::move(logger);
}

void stop_logging() {
  std::shared_ptr<const Logger> last;
  const std::lock_guard lock(mutex);
  last.swap(current);  // the thread pool's destructor writes what waits
}

void log(LogLevel level, std::string_view component, std::string_view message, const LogFields& fields) noexcept {
  try {
    const std::shared_ptr<const Logger> logger = current_logger();
    if (!logger) return;
    const auto format = logger->json ? format_log_json : format_log_text;
    logger->front->log(spdlog_level(level), format(utc_now(), level, component, message, fields));
  } catch (...) {  // out of memory: a lost record must not stop a capture
  }
}

std::uint64_t log_records_dropped() {
  const std::shared_ptr<const Logger> logger = current_logger();
  return logger ? logger->writer->overrun_counter() : 0;
}

std::string format_log_text(std::string_view time, LogLevel level, std::string_view component, std::string_view message,
                            const LogFields& fields) {
  std::string line = std::string(time) + " " + name(level) + " " + escaped(component) + ": " + escaped(message);
  for (const LogField& field : fields) line += " " + escaped(field.key) + "=" + as_text(field);
  return line;
}

std::string format_log_json(std::string_view time, LogLevel level, std::string_view component, std::string_view message,
                            const LogFields& fields) {
  nlohmann::ordered_json record = {
      {"time", time}, {"level", name(level)}, {"component", component}, {"message", message}};
  for (const LogField& field : fields) record[field.key] = as_json(field);
  return record.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sheen
