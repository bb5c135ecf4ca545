// SPDX-License-Identifier: Apache-2.0
#include "common/link/monitor_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/link.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;
using testing::eventually;
using ::testing::HasSubstr;
using testing::kAnyPort;
using testing::kLong;

PublisherOptions publisher_options() {
  PublisherOptions options;
  options.endpoint = kAnyPort;
  return options;
}

SubscriberOptions subscriber_options(const std::string& endpoint) {
  SubscriberOptions options;
  options.endpoint = endpoint;
  return options;
}

Status status(const std::string& message, std::size_t preview_bytes = 0) {
  Status s{.role = "tracker", .source_session = "s", .state = SourceState::kLive, .message = message};
  s.gauges = {{"frame_rate_hz", 30}};
  s.preview_jpeg.assign(preview_bytes, 0xD8);
  return s;
}

/// Publishes a status again and again, as daemons do, until the subscriber sees it.
Status publish_until_seen(MonitorPublisher& publisher, MonitorSubscriber& subscriber, const Status& status) {
  Status last;
  EXPECT_TRUE(eventually([&] {
    publisher.publish(status);
    if (auto seen = subscriber.next(20ms)) last = *seen;
    return last.message == status.message;
  })) << "last was "
      << last.message;
  return last;
}

TEST(Monitor, ASubscriberSeesTheStatus) {
  MonitorPublisher publisher(publisher_options());
  MonitorSubscriber subscriber(subscriber_options(publisher.endpoint()));
  const Status seen = publish_until_seen(publisher, subscriber, status("hello", 500));
  EXPECT_EQ(seen.role, "tracker");
  EXPECT_EQ(seen.state, SourceState::kLive);
  EXPECT_EQ(seen.gauges.at("frame_rate_hz"), 30);
  EXPECT_EQ(seen.preview_jpeg, Bytes(500, 0xD8));
  EXPECT_GT(seen.sequence, 0u);
  EXPECT_GT(seen.clock_ns, 0);
}

TEST(Monitor, ASlowSubscriberSeesTheNewestAndDelaysNobody) {
  MonitorPublisher publisher(publisher_options());
  MonitorSubscriber slow(subscriber_options(publisher.endpoint()));
  const std::uint64_t before = publish_until_seen(publisher, slow, status("joining")).sequence;
  for (int i = 0; i < 2000; ++i) publisher.publish(status("burst", 50'000));
  ASSERT_TRUE(eventually([&] {
    const PublisherStats stats = publisher.stats();
    return stats.published + stats.replaced >= before + 2000;
  }));
  std::this_thread::sleep_for(50ms);
  publish_until_seen(publisher, slow, status("newest"));
  EXPECT_LT(slow.stats().received, 1000u);
}

TEST(Monitor, APreviewThatIsTooLargeIsLeftOutAndCounted) {
  MonitorPublisher publisher(publisher_options());
  MonitorSubscriber subscriber(subscriber_options(publisher.endpoint()));
  EXPECT_TRUE(publish_until_seen(publisher, subscriber, status("large", kMaxStatusBytes)).preview_jpeg.empty());
  EXPECT_TRUE(eventually([&] { return publisher.stats().previews_dropped >= 1; })) << "counted after it was sent";
}

TEST(Monitor, ASubscriberOutlivesThePublisher) {
  const std::string endpoint = testing::free_endpoint();
  PublisherOptions options = publisher_options();
  options.endpoint = endpoint;
  MonitorSubscriber subscriber(subscriber_options(endpoint));
  EXPECT_FALSE(subscriber.next(50ms));
  for (int run = 0; run < 2; ++run) {
    MonitorPublisher publisher(options);
    publish_until_seen(publisher, subscriber, status("run " + std::to_string(run)));
  }
}

TEST(Monitor, WhatIsNoStatusIsCounted) {
  zmq::context_t context;
  zmq::socket_t publisher(context, zmq::socket_type::pub);
  publisher.bind(kAnyPort);
  MonitorSubscriber subscriber(subscriber_options(publisher.get(zmq::sockopt::last_endpoint)));
  EXPECT_TRUE(eventually([&] {
    publisher.send(zmq::str_buffer("SHEN is not enough"));
    EXPECT_FALSE(subscriber.next(10ms));
    return subscriber.stats().rejected > 0;
  }));
  EXPECT_THAT(subscriber.stats().last_error, HasSubstr("version"));
}

TEST(Monitor, AStatusOfSeveralPartsIsRefusedAndTheWatcherGoesOn) {
  zmq::context_t context{1};
  zmq::socket_t publisher(context, zmq::socket_type::pub);
  publisher.set(zmq::sockopt::linger, 0);
  publisher.bind(kAnyPort);
  MonitorSubscriber subscriber(subscriber_options(publisher.get(zmq::sockopt::last_endpoint)));
  const Bytes good = encode_status(status("good"));
  EXPECT_TRUE(eventually([&] {
    for (int i = 0; i < 20; ++i) {
      publisher.send(zmq::buffer(good), zmq::send_flags::sndmore);
      publisher.send(zmq::buffer(good), zmq::send_flags::none);
    }
    EXPECT_FALSE(subscriber.next(5ms));
    return subscriber.stats().rejected > 100;
  }));
  EXPECT_THAT(subscriber.stats().last_error, HasSubstr("number of parts"));
  EXPECT_TRUE(eventually([&] {
    publisher.send(zmq::buffer(good), zmq::send_flags::none);
    return subscriber.next(5ms).has_value();
  }));
}

TEST(Monitor, CurveLetsThoseInWhoMayWatch) {
  const TempFolder temp;
  const CurveKeys server = generate_keys(temp.path(), "server"), desk = generate_keys(temp.path(), "desk"),
                  stranger = generate_keys(temp.path(), "stranger");
  PublisherOptions options = publisher_options();
  options.keys = server;
  options.allowlist = temp.write("allowed", desk.public_key + " monitor desk\n" + stranger.public_key + " nobody x\n");
  MonitorPublisher publisher(options);
  SubscriberOptions allowed = subscriber_options(publisher.endpoint());
  allowed.keys = desk;
  allowed.server_public_key = server.public_key;
  SubscriberOptions refused = allowed;
  refused.keys = stranger;
  MonitorSubscriber watching(allowed), shut_out(refused);
  publish_until_seen(publisher, watching, status("hello"));
  EXPECT_TRUE(eventually([&] { return publisher.stats().refused_keys > 0; }));
  EXPECT_FALSE(shut_out.next(50ms));
  EXPECT_EQ(shut_out.stats().received, 0u);
}

TEST(Monitor, BeyondLoopbackKeysAreRequired) {
  PublisherOptions options;
  options.endpoint = "tcp://*:7411";
  EXPECT_THROW(MonitorPublisher{options}, ConfigError);
  EXPECT_THROW(MonitorSubscriber{subscriber_options("tcp://example.org:7411")}, ConfigError);
  const MonitorPublisher first(publisher_options());
  options.endpoint = first.endpoint();
  EXPECT_THROW(MonitorPublisher{options}, DeviceError);
}

}  // namespace
}  // namespace sheen
