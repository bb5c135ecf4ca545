// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/setup_checks.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>

#include "common/link/transport.h"
#include "common/session/session.h"
#include "reconstructor/monitor/monitor_server.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

class SetupChecks : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::path(testing::TempDir()) / "sheen_setup_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  fs::path folder_;
};

TEST_F(SetupChecks, MeshIsReadAndItsFaultsNamed) {
  const fs::path sheet = write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::vector<SetupCheck> checks = check_mesh(sheet);
  EXPECT_EQ(checks.front().finding, Finding::kOk);
  EXPECT_THAT(checks.front().text, HasSubstr("1 triangles, 3 vertices"));
  ASSERT_GE(checks.size(), 2U) << "an open sheet has a border";
  EXPECT_EQ(checks[1].finding, Finding::kWarn);
  EXPECT_EQ(check_mesh(folder_ / "none.ply").front().finding, Finding::kFail);
  EXPECT_EQ(check_mesh(write("broken.obj", "v 0 0 0\nf 1 2 9\n")).front().finding, Finding::kFail);
}

TEST_F(SetupChecks, AMeshThatIsNotInMetresIsDoubted) {
  for (const char* side : {"118", "2500", "0.0001"}) {
    const std::string length = side;
    const fs::path mesh = write("mesh.obj", "v 0 0 0\nv " + length + " 0 0\nv 0 " + length + " 0\nf 1 2 3\n");
    const SetupCheck check = check_mesh(mesh).front();
    EXPECT_EQ(check.finding, Finding::kWarn) << side;
    EXPECT_THAT(check.text, HasSubstr("a mesh is in metres"));
  }
}

TEST_F(SetupChecks, SecretKeyMustBeReadableAndPrivate) {
  generate_keys(folder_, "rig");
  const fs::path key = folder_ / "rig.key";
  EXPECT_EQ(check_secret_key(key).finding, Finding::kOk);
  EXPECT_EQ(check_public_key(folder_ / "rig.pub").finding, Finding::kOk);
  fs::permissions(key, fs::perms::owner_read | fs::perms::group_read);
  EXPECT_EQ(check_secret_key(key).finding, Finding::kFail);
  EXPECT_THAT(check_secret_key(key).text, HasSubstr("chmod 600"));
  EXPECT_EQ(check_secret_key(folder_ / "none.key").finding, Finding::kFail);
  EXPECT_EQ(check_public_key(write("bad.pub", "no key")).finding, Finding::kFail);
}

TEST_F(SetupChecks, EndpointThatAnswersIsToldFromOneThatDoesNot) {
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string endpoint = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  // Bound and not listening: the port is refused, and nobody else can take it meanwhile.
  EXPECT_EQ(check_endpoint(endpoint, false, 1s).finding, Finding::kWarn);
  EXPECT_THAT(check_endpoint(endpoint, false, 1s).text, HasSubstr("sheen-tracker run"));
  ASSERT_EQ(::listen(listener, 4), 0);
  EXPECT_EQ(check_endpoint(endpoint, false, 1s).finding, Finding::kOk);
  ::close(listener);
}

TEST_F(SetupChecks, EndpointsThatCannotWorkFail) {
  for (const char* endpoint :
       {"", "127.0.0.1:7410", "tcp://", "tcp://:7410", "tcp://127.0.0.1", "tcp://127.0.0.1:", "ipc:///tmp/x"})
    EXPECT_EQ(check_endpoint(endpoint, false, 100ms).finding, Finding::kFail) << endpoint;
  const SetupCheck open = check_endpoint("tcp://192.0.2.1:7410", false, 100ms);
  EXPECT_EQ(open.finding, Finding::kFail);
  EXPECT_THAT(open.text, HasSubstr("--keys"));
  EXPECT_NE(check_endpoint("tcp://192.0.2.1:7410", true, 100ms).finding, Finding::kOk);
}

TEST_F(SetupChecks, SessionIsNewContinuedOrInTheWay) {
  EXPECT_EQ(check_session(folder_ / "new").front().finding, Finding::kOk);
  EXPECT_FALSE(fs::exists(folder_ / "new")) << "looking must not create anything";
  { Session::create(folder_ / "session"); }
  EXPECT_THAT(check_session(folder_ / "session").front().text, HasSubstr("0 captures, will be continued"));
  write("notes.txt", "mine");
  EXPECT_EQ(check_session(folder_).front().finding, Finding::kFail);
  EXPECT_EQ(check_session(folder_).back().name, "disk");
}

TEST_F(SetupChecks, MonitorPortInUseIsNoticed) {
  int port = 0;
  {
    const MonitorServer server({.port = 0});
    port = server.port();
    EXPECT_EQ(check_monitor_port(port).finding, Finding::kFail) << "`serve` does not start there";
  }
  EXPECT_EQ(check_monitor_port(port).finding, Finding::kOk);
}

TEST_F(SetupChecks, DisplayThatNobodyServesIsNoticed) {
  ::unsetenv("WAYLAND_DISPLAY");
  ::setenv("DISPLAY", ":4093", 1);
  EXPECT_EQ(check_display().finding, Finding::kWarn);
  ::unsetenv("DISPLAY");
  EXPECT_THAT(check_display().text, HasSubstr("no window"));
}

}  // namespace
}  // namespace sheen
