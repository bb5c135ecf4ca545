// SPDX-License-Identifier: Apache-2.0
#include "common/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <memory>
#include <thread>
#include <vector>

namespace sheen {
namespace {

using namespace std::chrono_literals;

TEST(BoundedQueue, GivesBackInOrderWhatWasPutIn) {
  BoundedQueue<int> queue(8);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(queue.push(int(i)));
  EXPECT_EQ(queue.size(), 8u);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(queue.pop_for(1h), i);
  EXPECT_EQ(queue.size(), 0u);
}

TEST(BoundedQueue, AFullQueueTakesNothingAndLeavesTheValueAlone) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  ASSERT_TRUE(queue.try_push(std::make_unique<int>(1)));
  auto second = std::make_unique<int>(2);
  EXPECT_FALSE(queue.try_push(std::move(second)));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(**queue.pop_for(1h), 1);
  EXPECT_TRUE(queue.try_push(std::move(second)));
  EXPECT_EQ(second, nullptr);
}

TEST(BoundedQueue, PopGivesUpAfterItsTime) {
  BoundedQueue<int> queue(1);
  EXPECT_EQ(queue.pop_for(0ms), std::nullopt);
  EXPECT_EQ(queue.pop_for(1ms), std::nullopt);
}

TEST(BoundedQueue, AClosedQueueRefusesAndDrains) {
  BoundedQueue<std::unique_ptr<int>> queue(4);
  queue.push(std::make_unique<int>(1));
  queue.push(std::make_unique<int>(2));
  EXPECT_FALSE(queue.closed());
  queue.close();
  EXPECT_TRUE(queue.closed());
  auto late = std::make_unique<int>(3);
  EXPECT_FALSE(queue.push(std::move(late)));
  EXPECT_FALSE(queue.try_push(std::move(late)));
  EXPECT_NE(late, nullptr) << "a value that was not taken is not lost";
  EXPECT_EQ(**queue.pop_for(1h), 1);
  EXPECT_EQ(**queue.pop_for(1ms), 2);
  EXPECT_EQ(queue.pop_for(1h), std::nullopt);
  EXPECT_EQ(queue.pop_for(1ms), std::nullopt);
}

TEST(BoundedQueue, ClosingWakesWhoeverWaitsForRoomOrForItems) {
  BoundedQueue<int> empty(1), full(1);
  full.push(1);
  auto waits_for_item = std::async(std::launch::async, [&] { return empty.pop_for(1h).has_value(); });
  auto waits_for_room = std::async(std::launch::async, [&] { return full.push(2); });
  EXPECT_EQ(waits_for_room.wait_for(20ms), std::future_status::timeout) << "a full queue makes its producer wait";
  empty.close();
  full.close();
  EXPECT_FALSE(waits_for_item.get());
  EXPECT_FALSE(waits_for_room.get());
  EXPECT_EQ(full.size(), 1u);
}

TEST(BoundedQueue, ManyProducersAndConsumersLoseNothingDoubleNothingAndKeepTheBound) {
  constexpr int kProducers = 4, kConsumers = 3, kEach = 2000;
  constexpr std::size_t kCapacity = 5;
  BoundedQueue<int> queue(kCapacity);
  std::atomic<bool> within_bound = true;
  std::vector<std::vector<int>> got(kConsumers);
  {
    std::vector<std::jthread> consumers;
    for (int c = 0; c < kConsumers; ++c)
      consumers.emplace_back([&, c] {
        while (const auto item = queue.pop_for(1h)) {
          got[c].push_back(*item);
          if (queue.size() > kCapacity) within_bound = false;
        }
      });
    {
      std::vector<std::jthread> producers;
      for (int p = 0; p < kProducers; ++p)
        producers.emplace_back([&, p] {
          for (int i = 0; i < kEach; ++i) queue.push(p * kEach + i);
        });
    }
    queue.close();
  }
  EXPECT_TRUE(within_bound);
  std::vector<int> all;
  for (const std::vector<int>& one : got) {
    // What one producer put in comes out in its order, whoever takes it.
    std::vector<int> last(kProducers, -1);
    for (const int item : one) {
      EXPECT_GT(item, last[item / kEach]);
      last[item / kEach] = item;
    }
    all.insert(all.end(), one.begin(), one.end());
  }
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), std::size_t(kProducers) * kEach);
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], static_cast<int>(i));
}

}  // namespace
}  // namespace sheen
