// SPDX-License-Identifier: Apache-2.0
#include "common/base/end_on_stop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "common/base/stop_signal.h"

namespace sheen {
namespace {

TEST(EndOnStopDeathTest, WorkThatNeverLooksIsEnded) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_stop_signals();
        const EndOnStop guard("stopped while nothing was looked at");
        std::raise(SIGTERM);
        std::this_thread::sleep_for(std::chrono::minutes(10));
      },
      testing::ExitedWithCode(1), "stopped while nothing was looked at");
}

TEST(EndOnStopDeathTest, WorkThatEndsByItselfIsLeftAlone) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_stop_signals();
        {
          const EndOnStop guard("ended");
          std::raise(SIGTERM);
        }
        std::this_thread::sleep_for(std::chrono::seconds(2));
        std::_Exit(7);
      },
      testing::ExitedWithCode(7), "^$");
}

TEST(PartsUntilStopDeathTest, FinishedPartsAreKeptAndTheOneUnderWayIsLeft) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_stop_signals();
        PartsUntilStop parts;
        const std::optional<int> first = parts.result([] { return 7; });
        const std::optional<int> second = parts.result([] {
          std::raise(SIGTERM);
          std::this_thread::sleep_for(std::chrono::minutes(10));
          return 8;
        });
        std::fprintf(stderr, "%d %d %d", first.value_or(0), second.value_or(0), parts.stopped());
      },
      testing::ExitedWithCode(1), "^7 0 1$");
}

TEST(PartsUntilStop, AnErrorIsThePartsOwn) {
  PartsUntilStop parts;
  EXPECT_THROW(parts.result([]() -> int { throw std::runtime_error("wrong"); }), std::runtime_error);
  EXPECT_EQ(parts.result([] { return 3; }), 3);
  EXPECT_FALSE(parts.stopped());
}

}  // namespace
}  // namespace sheen
