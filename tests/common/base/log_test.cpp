// SPDX-License-Identifier: Apache-2.0
#include "common/base/log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/errors.h"

namespace sheen {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kTime = "2026-01-02T03:04:05.678Z";

std::filesystem::path temporary(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / (name + std::to_string(::getpid()));
  std::filesystem::remove(path);
  return path;
}

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Log, TextReadsAsALine) {
  EXPECT_EQ(
      format_log_text(kTime, LogLevel::kWarning, "link", "gap",
                      {{"after", 12}, {"lost", std::uint64_t(3)}, {"rate", 2.5}, {"live", false}, {"host", "a b"}}),
      "2026-01-02T03:04:05.678Z warning link: gap after=12 lost=3 rate=2.5 live=false host=\"a b\"");
}

TEST(Log, TextCannotBeForged) {
  const std::string line =
      format_log_text(kTime, LogLevel::kInfo, "link", "from \n2026 error \x1b[31m", {{"id", "x\ny"}});
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  EXPECT_THAT(line, Not(HasSubstr("\x1b")));
  EXPECT_THAT(line, HasSubstr("\\x0a2026"));
}

TEST(Log, JsonKeepsTypesAndSurvivesBadText) {
  const auto record = nlohmann::json::parse(format_log_json(kTime, LogLevel::kError, "journal", "disk \"full\"\n",
                                                            {{"sequence", 7},
                                                             {"update_fraction", 0.5},
                                                             {"nan", std::numeric_limits<double>::quiet_NaN()},
                                                             {"ok", true},
                                                             {"path", "caf\xe9"}}));
  EXPECT_EQ(record["time"], kTime);
  EXPECT_EQ(record["level"], "error");
  EXPECT_EQ(record["component"], "journal");
  EXPECT_EQ(record["message"], "disk \"full\"\n");
  EXPECT_EQ(record["sequence"], 7);
  EXPECT_EQ(record["update_fraction"], 0.5);
  EXPECT_TRUE(record["nan"].is_null());
  EXPECT_EQ(record["ok"], true);
  EXPECT_EQ(record["path"], "caf\xef\xbf\xbd");
}

TEST(Log, WritesRecordsInOrder) {
  const std::filesystem::path path = temporary("log_test_order");
  start_logging({.json = true, .file = path});
  for (int i = 0; i < 100; ++i) log_info("test", "record", {{"i", i}});
  stop_logging();
  log_info("test", "after the end");
  const std::vector<std::string> lines = lines_of(path);
  ASSERT_EQ(lines.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(nlohmann::json::parse(lines[static_cast<std::size_t>(i)])["i"], i);
}

TEST(Log, RefusesAFileThatCannotBeWritten) {
  EXPECT_THROW(start_logging({.file = "/dev/null/log"}), FileError);
}

// A pipe that nobody reads stands for a terminal that is stopped: far more is logged than pipe and queue hold.
TEST(Log, NeverWaitsForAStuckReaderAndCountsWhatItDrops) {
  constexpr int kRecords = 5000;
  const std::filesystem::path path = temporary("log_test_pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDWR | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  start_logging({.file = path, .queue = 16});
  for (int i = 0; i < kRecords; ++i) log_info("test", std::string(200, 'x'), {{"i", i}});
  EXPECT_GT(log_records_dropped(), 1000U);

  std::jthread drain([reader](std::stop_token stop) {
    std::vector<char> buffer(1 << 16);
    while (!stop.stop_requested()) {
      pollfd readable{reader, POLLIN, 0};
      if (::poll(&readable, 1, 10) > 0 && ::read(reader, buffer.data(), buffer.size()) < 0) return;
    }
  });
  stop_logging();
  drain.request_stop();
  drain.join();
  ::close(reader);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace sheen
