// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/tracker_links.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/expect_error.h"
#include "tests/support/link.h"

namespace sheen {
namespace {

using namespace testing;
using std::chrono::milliseconds;

class TwoLinks : public ::testing::Test {
 protected:
  CaptureSender a_{sender_options(kAnyPort, "a")}, b_{sender_options(kAnyPort, "b")};
  TrackerLinks links_{{receiver_options(a_.endpoint()), receiver_options(b_.endpoint())}};
};

TEST_F(TwoLinks, TakeInTurnsAndAcknowledgeToWhoSentIt) {
  keep(a_, 1, 6, "a");
  keep(b_, 1, 6, "b");
  std::map<std::string, std::uint64_t> last;
  for (int i = 0; i < 12; ++i) {
    const auto arrival = links_.next(kLong);
    ASSERT_TRUE(arrival);
    const Capture& capture = arrival->received.capture;
    EXPECT_EQ(capture.source_session, arrival->tracker == 0 ? "a" : "b");
    EXPECT_EQ(capture.sequence, ++last[capture.source_session]);
    EXPECT_EQ(capture.image, sample_capture(capture.source_session, capture.sequence).image);
    if (arrival->tracker == 0) links_.acknowledge(*arrival);
  }
  EXPECT_TRUE(eventually([&] { return a_.stats().acknowledged == 6; }));
  EXPECT_EQ(b_.stats().acknowledged, 0u) << "what the other sent is none of its business";
  EXPECT_EQ(b_.stats().rejected_messages + a_.stats().rejected_messages, 0u);
  EXPECT_FALSE(links_.next(milliseconds(20)));
}

TEST_F(TwoLinks, AreOverWhenBothAre) {
  keep(a_, 1, 1, "a");
  const auto arrival = links_.next(kLong);
  ASSERT_TRUE(arrival);
  links_.acknowledge(*arrival);
  EXPECT_TRUE(a_.finish(kLong));
  ASSERT_TRUE(eventually([&] { return links_.states()[0].stats.ended; }));
  EXPECT_FALSE(joined(links_.states()).ended);
  EXPECT_TRUE(b_.finish(kLong, "the cable"));
  ASSERT_TRUE(eventually([&] { return joined(links_.states()).ended; }));
  EXPECT_EQ(joined(links_.states()).source_failure, b_.endpoint() + ": the cable");
}

TEST(TrackerLinks, NeedAnEndpointEach) {
  expect_error<ConfigError>(
      [] {
        TrackerLinks({receiver_options("tcp://127.0.0.1:9"), receiver_options("tcp://127.0.0.1:9")});
      },
      {"tcp://127.0.0.1:9", "twice"});
}

TEST(JoinedLinks, AddUpAndNameWhoIsGone) {
  LinkState left{"L", {}}, right{"R", {}};
  left.stats.connected = left.stats.came = right.stats.came = true;
  left.stats.kept = 3;
  right.stats.kept = 4;
  left.stats.motion = right.stats.motion = {Motion::kStill, Motion::kStill};
  left.stats.tracker = {10, {{"motion_blur", 2}}, "too fast: motion blur"};
  right.stats.tracker = {20, {{"motion_blur", 5}, {"too_near", 1}}, "too fast: motion blur"};
  const ReceiverStats both = joined({left, right});
  EXPECT_EQ(both.kept, 7u);
  EXPECT_EQ(both.tracker.judged, 30u);
  EXPECT_EQ(both.tracker.refused.at("motion_blur"), 7u);
  EXPECT_EQ(both.tracker.trouble, "L: too fast: motion blur") << "the other one is not there to be in trouble";
  EXPECT_EQ(both.last_error, "R: the tracker is gone");
  EXPECT_TRUE(both.connected);
  EXPECT_EQ(both.motion.camera, Motion::kMoves) << "two cameras that stand still are two views";
  EXPECT_EQ(both.motion.light, Motion::kStill);
  EXPECT_EQ(joined({right}).tracker.trouble, "too fast: motion blur");
}

}  // namespace
}  // namespace sheen
