// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/packet_queue.h"

#include <gtest/gtest.h>

extern "C" {
#include <libavcodec/packet.h>
}

namespace sheen {
namespace {

/// A picture that needs no other (I) or those before it (P).
void put(PacketQueue& queue, char kind, std::int64_t number) {
  PacketPtr packet = make_packet();
  if (kind == 'I') packet->flags |= AV_PKT_FLAG_KEY;
  queue.put(std::move(packet), number);
}

TEST(PacketQueue, APictureThatNeedsNoOtherOvertakesThoseThatWait) {
  PacketQueue queue;
  for (int i = 1; i <= 5; ++i) put(queue, 'I', i);
  EXPECT_EQ(queue.waiting(), 1u);
  EXPECT_EQ(queue.overtaken(), 4u);
  EXPECT_EQ(queue.take().at_ns, 5);
}

TEST(PacketQueue, PicturesThatNeedEachOtherWaitUntilTheyAreTooMany) {
  PacketQueue queue;
  std::int64_t number = 0;
  put(queue, 'I', ++number);
  while (queue.overtaken() == 0 && number < 10'000) put(queue, 'P', ++number);
  EXPECT_EQ(queue.waiting(), 0u) << "none of them can be decoded now";
  EXPECT_EQ(queue.overtaken(), static_cast<std::uint64_t>(number));
  EXPECT_LT(number, 200) << "no long delay";
  put(queue, 'P', ++number);
  EXPECT_EQ(queue.waiting(), 0u) << "nor this one";
  put(queue, 'I', ++number);
  put(queue, 'P', ++number);
  EXPECT_EQ(queue.take().at_ns, number - 1);
  EXPECT_EQ(queue.take().at_ns, number);
}

TEST(PacketQueue, ItsEndComesAfterWhatWaits) {
  PacketQueue queue;
  put(queue, 'I', 1);
  queue.end("has ended");
  EXPECT_TRUE(queue.take().packet);
  EXPECT_FALSE(queue.take().packet);
  EXPECT_EQ(queue.why_ended(), "has ended");
}

}  // namespace
}  // namespace sheen
