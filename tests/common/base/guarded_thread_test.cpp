// SPDX-License-Identifier: Apache-2.0
#include "common/base/guarded_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <new>

#include "common/base/errors.h"
#include "common/base/repeated_work.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;

struct NotAStandardOne {};

/// What is told of a thread whose work throws.
template <typename Thrown>
std::string told_of(Thrown thrown) {
  std::string told;
  guarded_thread([thrown] { throw thrown; }, [&told](const std::exception_ptr& error) { told = words_of(error); })
      .join();
  return told;
}

TEST(GuardedThread, WhateverItsWorkThrowsIsToldAndEndsNothing) {
  EXPECT_EQ(told_of(DeviceError("the camera is gone")), "the camera is gone");
  EXPECT_EQ(told_of(std::bad_alloc()), "out of memory");
  EXPECT_EQ(told_of(7), "unknown error");
  EXPECT_EQ(told_of(NotAStandardOne{}), "unknown error");
}

TEST(GuardedThread, WhoIsToldMayFailToo) {
  guarded_thread([] { throw std::bad_alloc(); }, [](const std::exception_ptr&) { throw std::bad_alloc(); }).join();
}

TEST(GuardedThread, WorkHearsThatItIsToStop) {
  std::atomic<bool> ended = false;
  guarded_thread(
      [&ended](const std::stop_token& stop) {
        while (!stop.stop_requested()) std::this_thread::sleep_for(1ms);
        ended = true;
      },
      [](const std::exception_ptr&) {});
  EXPECT_TRUE(ended);
}

TEST(GuardedThread, OneThatNobodyWaitsForIsGuardedToo) {
  const auto told = std::make_shared<std::promise<std::string>>();
  detached_thread([] { throw std::bad_alloc(); },
                  [told](const std::exception_ptr& error) { told->set_value(words_of(error)); });
  EXPECT_EQ(told->get_future().get(), "out of memory");
}

TEST(RepeatedWork, GoesOnAfterRoundsThatFail) {
  std::atomic<int> rounds = 0;
  {
    const RepeatedWork work("display", 1ms, [&rounds] {
      if (++rounds % 2 == 1) throw std::bad_alloc();
      if (rounds % 4 == 0) throw NotAStandardOne{};
    });
    while (rounds < 10) std::this_thread::sleep_for(1ms);
  }
  const int after = rounds;
  std::this_thread::sleep_for(10ms);
  EXPECT_EQ(rounds, after) << "it ends with its object";
}

}  // namespace
}  // namespace sheen
