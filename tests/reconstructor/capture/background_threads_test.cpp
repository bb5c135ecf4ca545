// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/background_threads.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <tbb/info.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <new>
#include <set>
#include <thread>

namespace sheen {
namespace {

int priority_of_this_thread() {
  return getpriority(PRIO_PROCESS, 0);
}

/// How many of so many tasks in parallel ran with a low priority, and on how many threads.
struct Ran {
  int low = 0;
  std::size_t threads = 0;
};
Ran run_in_parallel(int tasks) {
  std::atomic<int> low = 0;
  std::mutex mutex;
  std::set<std::thread::id> threads;
  tbb::parallel_for(0, tasks, [&](int) {
    low += priority_of_this_thread() >= 10;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  return {low, threads.size()};
}

class BackgroundThreadsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (priority_of_this_thread() >= 10) GTEST_SKIP() << "the tests themselves run with a low priority";
  }
};

TEST_F(BackgroundThreadsTest, OnlyTheirThreadAndItsHelpersLetOthersGoFirst) {
  constexpr int kTasks = 300;
  const int before = priority_of_this_thread();
  for (int round = 0; round < 3; ++round) {
    Ran background;
    std::thread([&] { BackgroundThreads().run([&] { background = run_in_parallel(kTasks); }); }).join();
    EXPECT_EQ(background.low, kTasks);
    EXPECT_EQ(background.threads > 1, tbb::info::default_concurrency() > 1);
    EXPECT_EQ(run_in_parallel(kTasks).low, 0) << "who draws afterwards has its priority still";
  }
  EXPECT_EQ(priority_of_this_thread(), before);
}

TEST_F(BackgroundThreadsTest, WhatTheirWorkThrowsComesOut) {
  std::thread([&] {
    EXPECT_THROW(BackgroundThreads().run([] { tbb::parallel_for(0, 100, [](int) { throw std::bad_alloc(); }); }),
                 std::bad_alloc);
  }).join();
}

}  // namespace
}  // namespace sheen
