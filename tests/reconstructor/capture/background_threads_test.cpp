// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/background_threads.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <thread>

namespace sheen {
namespace {

int priority_of_this_thread() {
  return getpriority(PRIO_PROCESS, 0);
}

TEST(BackgroundThreads, OnlyTheirThreadAndItsWorkersLetOthersGoFirst) {
  const int before = priority_of_this_thread();
  if (before >= 10) GTEST_SKIP() << "the tests themselves run with a low priority";
  std::atomic<int> tasks = 0, in_background = 0;
  std::thread([&] {
    const BackgroundThreads background;
    tbb::parallel_for(0, 1000, [&](int) {
      ++tasks;
      in_background += priority_of_this_thread() >= 10;
      std::this_thread::yield();
    });
  }).join();
  EXPECT_EQ(tasks, 1000);
  EXPECT_EQ(in_background, 1000);
  EXPECT_EQ(priority_of_this_thread(), before);
}

}  // namespace
}  // namespace sheen
