// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "reconstructor/monitor/monitor_server.h"
#include "tests/reconstructor/monitor/sample_state.h"

namespace sheen {
namespace {

using testing::HasSubstr;

TEST(MonitorClient, ReadsAReconstructorsStatusAsALine) {
  MonitorServer server({.port = 0, .token = "0123456789abcdef"});
  server.publish(sample_monitor_state());
  EXPECT_EQ(status_line(fetch_status(server.url(), "0123456789abcdef")),
            "live  121 images of 160  34.31 dB (constant colour 28.87)  8.4 images/s  budget NOT KEPT  journal 5  send "
            "31/64");
  EXPECT_THROW(fetch_status(server.url(), ""), DeviceError);
  EXPECT_THROW(fetch_status(server.url(), "0123456789abcdeX"), DeviceError);
}

TEST(MonitorClient, SaysWhatStoppedACapture) {
  MonitorServer server({.port = 0});
  MonitorState state;
  state.error = "the disk is full";
  server.publish(state);
  EXPECT_THAT(status_line(fetch_status(server.url(), "")), HasSubstr("failed (the disk is full)  0 images of 0"));
}

TEST(MonitorClient, NobodyThereAndNoAddress) {
  std::string url;
  {
    const MonitorServer server({.port = 0});
    url = server.url();
  }
  EXPECT_THROW(fetch_status(url, ""), DeviceError);
  for (const char* wrong : {"", "127.0.0.1:7480", "https://127.0.0.1", "tcp://127.0.0.1:7410"})
    EXPECT_THROW(fetch_status(wrong, ""), ConfigError) << wrong;
}

TEST(MonitorClient, APortThatIsNoneIsNamed) {
  const MonitorServer server({.port = 0});
  const std::string same_lower_bits = std::to_string(server.port() + 65536);
  for (const std::string& port :
       {same_lower_bits, std::string("0"), std::string("-1"), std::string("http"), std::string()})
    EXPECT_THROW(fetch_status("http://127.0.0.1:" + port + "/", ""), ConfigError) << port;
}

TEST(MonitorClient, SaysHowFarTheEndIs) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.ending = {CaptureState::kFinishing, 45, 90};
  server.publish(state);
  EXPECT_THAT(status_line(fetch_status(server.url(), "")), testing::StartsWith("finishing 45/90  121 images"));
}

TEST(MonitorClient, RefusesWhatIsNoStatus) {
  for (const char* text : {"", "<html>", "{}", "[]", "null", "{\"state\": 3}"})
    EXPECT_THROW(status_line(text), ProtocolError) << text;
}

}  // namespace
}  // namespace sheen
