// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "common/base/errors.h"
#include "tests/reconstructor/monitor/exposition_parser.h"
#include "tests/reconstructor/monitor/sample_state.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kToken = "0123456789abcdef";

httplib::Result get(const MonitorServer& server, const std::string& path, const httplib::Headers& headers = {}) {
  return httplib::Client("127.0.0.1", server.port()).Get(path, headers);
}

/// A TCP connection that says no more than it is told to.
class RawClient {
 public:
  explicit RawClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const int small = 4096;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &small, sizeof(small));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~RawClient() { ::close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool connected() const { return connected_; }
  /// False when the other end is gone.
  bool say(const std::string& text) const {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  /// Everything until the other end closes.
  std::string hears() const {
    std::string heard(1 << 20, '\0');
    std::size_t size = 0;
    for (ssize_t n = 1; n > 0; size += static_cast<std::size_t>(std::max<ssize_t>(n, 0)))
      n = ::recv(socket_, heard.data() + size, heard.size() - size, 0);
    heard.resize(size);
    return heard;
  }
  /// Whether the other end closes within so long.
  bool closed(milliseconds patience) const {
    pollfd polled{socket_, POLLIN, 0};
    return ::poll(&polled, 1, static_cast<int>(patience.count())) > 0;
  }

 private:
  int socket_;
  bool connected_ = false;
};

TEST(MonitorServer, AnswersEveryEndpoint) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.preview_jpeg = std::make_shared<const std::string>("\xff\xd8 preview \0 bytes", 17);
  server.publish(state);

  auto page = get(server, "/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->get_header_value("Content-Type"), HasSubstr("text/html"));
  for (const char* endpoint : {"status.json", "metrics", "preview.jpg", "camera.jpg", "healthz"})
    EXPECT_THAT(page->body, HasSubstr(std::string("href=\"") + endpoint + "\""));
  EXPECT_THAT(page->body, Not(HasSubstr("src=\"http")));
  EXPECT_THAT(page->body, Not(HasSubstr("@MONITOR")));

  auto status = get(server, "/status.json");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->get_header_value("Content-Type"), "application/json");
  EXPECT_EQ(nlohmann::json::parse(status->body)["frames"]["accepted"], 121);
  EXPECT_EQ(nlohmann::json::parse(status->body)["state"], "live");

  auto metrics = get(server, "/metrics");
  ASSERT_TRUE(metrics);
  EXPECT_THAT(metrics->get_header_value("Content-Type"), HasSubstr("version=0.0.4"));
  EXPECT_EQ(parse_exposition(metrics->body).value("sheen_frames_accepted_total"), 121);

  auto preview = get(server, "/preview.jpg");
  ASSERT_TRUE(preview);
  EXPECT_EQ(preview->get_header_value("Content-Type"), "image/jpeg");
  EXPECT_EQ(preview->body, *state.preview_jpeg);
  EXPECT_EQ(get(server, "/camera.jpg")->status, 404);

  auto health = get(server, "/healthz");
  EXPECT_EQ(health->status, 200);
  EXPECT_EQ(health->body, "live\n");

  auto nothing = get(server, "/secret");
  EXPECT_EQ(nothing->status, 404);
  EXPECT_THAT(nothing->body, HasSubstr("/status.json"));
}

TEST(MonitorServer, ShowsTheNewestStateAndNumbersItsPictures) {
  MonitorServer server({.port = 0});
  const auto pictures = [&] { return nlohmann::json::parse(get(server, "/status.json")->body)["pictures"]; };
  EXPECT_EQ(nlohmann::json::parse(get(server, "/status.json")->body)["state"], "waiting");
  EXPECT_EQ(pictures()["preview"], 0);
  MonitorState state = sample_monitor_state();
  state.preview_jpeg = std::make_shared<const std::string>("one");
  server.publish(state);
  server.publish(state);
  EXPECT_EQ(pictures()["preview"], 1);
  state.preview_jpeg = std::make_shared<const std::string>("two");
  server.publish(state);
  EXPECT_EQ(pictures()["preview"], 2);
  EXPECT_EQ(get(server, "/preview.jpg")->body, "two");
}

TEST(MonitorServer, FailureShowsInHealth) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.error = "the disk is full";
  server.publish(state);
  EXPECT_EQ(get(server, "/healthz")->status, 503);
  EXPECT_EQ(get(server, "/healthz")->body, "failed\n");
}

/// Answers with what it was asked.
class SpokenModel : public ServedModel {
 public:
  bool there() const override { return there_; }
  std::string_view page() const override { return "<!doctype html>the model"; }
  Answer scene() override { return there_ ? Answer{200, "scene"} : Answer{404, "There is no model yet.\n"}; }
  Answer changes_for(const DeskQuestion& asked) override {
    return {busy_ ? 503 : 200, std::to_string(asked.scene) + " " + std::to_string(asked.changes) + " " +
                                   std::to_string(asked.eye[0]) + " " + std::to_string(asked.eye[2]) +
                                   (asked.moved ? " moved" : "")};
  }
  bool there_ = true, busy_ = false;
};

TEST(MonitorServer, DesksThatDrawTheModelThemselvesAreAnswered) {
  SpokenModel model;
  MonitorServer server({.port = 0, .model = &model});
  const auto model_page = [&] {
    return nlohmann::json::parse(get(server, "/status.json")->body)["pictures"]["model_page"];
  };
  EXPECT_EQ(model_page(), true);
  const auto page = get(server, "/model/");
  EXPECT_EQ(page->body, model.page());
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("frame-ancestors 'self'"));
  EXPECT_THAT(get(server, "/")->get_header_value("Content-Security-Policy"), HasSubstr("frame-ancestors 'none'"));
  EXPECT_EQ(get(server, "/model/scene")->body, "scene");
  const std::string asked = "/model/changes?scene=4294967295&changes=7&eye=1.5,-2e-3,0.25";
  EXPECT_EQ(get(server, asked)->body, "4294967295 7 1.500000 0.250000");
  EXPECT_EQ(get(server, asked + "&moved=1")->body, "4294967295 7 1.500000 0.250000 moved");
  model.busy_ = true;
  EXPECT_EQ(get(server, asked)->status, 503);
  model.there_ = false;
  EXPECT_EQ(model_page(), false);
  EXPECT_EQ(get(server, "/model/scene")->status, 404);
}

TEST(MonitorServer, AQuestionOfADeskThatIsNoneIsRefused) {
  SpokenModel model;
  MonitorServer server({.port = 0, .model = &model});
  for (const char* query :
       {"", "?scene=1&changes=1", "?scene=1&changes=1&eye=1,2", "?scene=1&changes=1&eye=1,2,3,4",
        "?scene=1&changes=1&eye=1,2,", "?scene=1&changes=1&eye=1,,3", "?scene=1&changes=1&eye=nan,0,0",
        "?scene=1&changes=1&eye=1,inf,0", "?scene=1&changes=1&eye=1e300,0,0", "?scene=-1&changes=1&eye=0,0,0",
        "?scene=4294967296&changes=1&eye=0,0,0", "?scene=1&changes=x&eye=0,0,0", "?changes=1&eye=0,0,0"})
    EXPECT_EQ(get(server, std::string("/model/changes") + query)->status, 400) << query;
  MonitorServer none({.port = 0});
  EXPECT_EQ(get(none, "/model/")->status, 404);
  MonitorServer guarded({.port = 0, .token = "0123456789abcdef", .model = &model});
  for (const char* path : {"/model/", "/model/scene", "/model/changes?scene=1&changes=1&eye=0,0,0"})
    EXPECT_EQ(get(guarded, path)->status, 401) << path;
}

class Steering : public testing::Test {
 protected:
  httplib::Result ask(const std::string& query, const std::string& token) {
    return httplib::Client("127.0.0.1", server_->port())
        .Post("/steer?" + query, {{"Authorization", "Bearer " + token}}, "", "text/plain");
  }
  void open(const std::string& watch_token, const std::string& steer_token) {
    server_.emplace(MonitorOptions{
        .port = 0, .token = watch_token, .steer_token = steer_token, .steer = [this](const SteerRequest& request) {
          asked_.push_back(std::string(to_string(request.action)) + " " + request.text);
          EXPECT_EQ(request.from, "127.0.0.1");
          return busy_;
        }});
  }
  bool may_steer(const httplib::Headers& headers) {
    return nlohmann::json::parse(get(*server_, "/status.json", headers)->body)["may_steer"];
  }

  static constexpr const char* kSteers = "fedcba9876543210";
  std::vector<std::string> asked_;
  std::string busy_;
  std::optional<MonitorServer> server_;
};

TEST_F(Steering, IsForThoseWithItsTokenAlone) {
  for (const std::string watch : {"", kToken}) {
    asked_.clear();
    open(watch, kSteers);
    EXPECT_EQ(ask("what=undo", kSteers)->status, 202);
    EXPECT_EQ(ask("what=hold-out", kSteers)->status, 202);
    EXPECT_EQ(ask("what=note&text=left%20lamp%20off%0a", kSteers)->status, 202);
    EXPECT_EQ(ask("what=finish", kSteers)->status, 202);
    EXPECT_EQ(asked_, (std::vector<std::string>{"undo ", "hold-out ", "note left lamp off ", "finish "}));

    const auto watching = watch.empty() ? httplib::Headers{} : httplib::Headers{{"Authorization", "Bearer " + watch}};
    EXPECT_TRUE(may_steer({{"Authorization", std::string("Bearer ") + kSteers}}));
    EXPECT_FALSE(may_steer(watching));
    EXPECT_EQ(
        httplib::Client("127.0.0.1", server_->port()).Post("/steer?what=undo", watching, "", "text/plain")->status,
        403);
    EXPECT_EQ(ask("what=undo", "0000000000000000")->status, 401);
    EXPECT_EQ(asked_.size(), 4u);
  }
}

TEST_F(Steering, NeedsAHeaderThatNoLinkAndNoOtherSiteCanSet) {
  open("", kSteers);
  httplib::Client client("127.0.0.1", server_->port());
  EXPECT_EQ(client.Post("/steer?what=undo&token=" + std::string(kSteers), "", "text/plain")->status, 403);
  EXPECT_EQ(get(*server_, "/steer?what=undo", {{"Authorization", std::string("Bearer ") + kSteers}})->status, 404);
  const auto preflight = client.Options("/steer");
  EXPECT_FALSE(preflight && preflight->has_header("Access-Control-Allow-Headers"));
  EXPECT_TRUE(asked_.empty());
}

TEST_F(Steering, WrongRequestsAreTold) {
  open("", kSteers);
  EXPECT_THAT(ask("what=explode", kSteers)->body, HasSubstr("undo, hold-out, pause, go-on, note or finish"));
  EXPECT_EQ(ask("", kSteers)->status, 400);
  EXPECT_EQ(ask("what=note", kSteers)->status, 400);
  EXPECT_EQ(ask("what=note&text=" + std::string(1001, 'x'), kSteers)->status, 400);
  EXPECT_TRUE(asked_.empty());
  busy_ = "too much was asked at once";
  EXPECT_EQ(ask("what=undo", kSteers)->status, 503);
}

TEST_F(Steering, WithoutATokenForItNobodyMay) {
  open("", "");
  EXPECT_EQ(ask("what=undo", "")->status, 403);
  EXPECT_EQ(ask("what=undo", kSteers)->status, 403);
  EXPECT_FALSE(may_steer({}));
  EXPECT_TRUE(asked_.empty());
  EXPECT_THROW(open("", "short"), ConfigError);
  EXPECT_THROW(open(kToken, kToken), ConfigError) << "whoever watches could steer";
}

TEST(MonitorServer, AsksForItsToken) {
  MonitorServer server({.port = 0, .token = kToken});
  server.publish(sample_monitor_state());
  for (const char* path : {"/", "/status.json", "/metrics", "/preview.jpg", "/camera.jpg", "/healthz", "/none"}) {
    EXPECT_EQ(get(server, path)->status, 401) << path;
    EXPECT_EQ(get(server, std::string(path) + "?token=0123456789abcdeX")->status, 401) << path;
    EXPECT_EQ(get(server, std::string(path) + "?token=")->status, 401) << path;
    EXPECT_EQ(get(server, path, {{"Authorization", std::string("Bearer ") + kToken + "0"}})->status, 401) << path;
    EXPECT_EQ(get(server, path, {{"Authorization", std::string("Basic ") + kToken}})->status, 401) << path;
  }
  const auto refusal = get(server, "/metrics");
  EXPECT_THAT(refusal->body, Not(HasSubstr("sheen_")));
  EXPECT_TRUE(refusal->has_header("WWW-Authenticate"));
  EXPECT_EQ(get(server, "/metrics", {{"Authorization", std::string("Bearer ") + kToken}})->status, 200);
  EXPECT_EQ(get(server, std::string("/status.json?token=") + kToken)->status, 200);
}

TEST(MonitorServer, GuessesAreSlowed) {
  MonitorServer server({.port = 0, .token = kToken});
  int status = 401;
  for (int i = 0; i < 100 && status == 401; ++i)
    status = get(server, "/status.json?token=guess" + std::to_string(i))->status;
  EXPECT_EQ(status, 429);
  EXPECT_EQ(get(server, std::string("/status.json?token=") + kToken)->status, 429);
  EXPECT_EQ(get(server, "/")->status, 401) << "no token is no guess";
}

TEST(MonitorServer, WithoutTokenAnswersToLoopbackNamesOnly) {
  MonitorServer server({.port = 0});
  EXPECT_EQ(get(server, "/status.json", {{"Host", "localhost:" + std::to_string(server.port())}})->status, 200);
  for (const char* host : {"evil.example", "127.0.0.1.evil.example", "127.evil.example:7480", "localhost.evil"})
    EXPECT_EQ(get(server, "/status.json", {{"Host", host}})->status, 403) << host;
}

TEST(MonitorServer, RefusesToBeSeenByOthersWithoutToken) {
  for (const char* host : {"0.0.0.0", "192.0.2.1", "::", "example.org", "127.evil.example"})
    EXPECT_THROW(MonitorServer({.host = host, .port = 0}), ConfigError) << host;
  EXPECT_THROW(MonitorServer({.host = "0.0.0.0", .port = 0, .token = "short"}), ConfigError);
  EXPECT_THROW(MonitorServer({.port = 70000}), ConfigError);
  EXPECT_NO_THROW(MonitorServer({.host = "localhost", .port = 0}));
}

TEST(MonitorServer, SaysThatThePortIsTaken) {
  const MonitorServer first({.port = 0});
  try {
    const MonitorServer second({.port = first.port()});
    FAIL() << "two servers share a port";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(first.port())));
    EXPECT_THAT(error.what(), HasSubstr("choose another port"));
  }
}

TEST(MonitorServer, APortIsFreeAgainAtOnce) {
  int port = 0;
  {
    const MonitorServer server({.port = 0});
    port = server.port();
    EXPECT_EQ(get(server, "/healthz")->status, 200);
  }
  const MonitorServer again({.port = port});
  EXPECT_EQ(get(again, "/healthz")->status, 200);
}

// Some say nothing, some stop in the middle of a request, some never read their answer. If any could hold up publishing
// or the end of the server, this test would not end.
TEST(MonitorServer, StuckClientsHoldUpNobodyWhoPublishes) {
  std::vector<std::unique_ptr<RawClient>> clients;
  {
    MonitorServer server({.port = 0});
    MonitorState state = sample_monitor_state();
    state.preview_jpeg = std::make_shared<const std::string>(std::string(4 << 20, 'x'));
    server.publish(state);
    for (int i = 0; i < 24; ++i) {
      clients.push_back(std::make_unique<RawClient>(server.port()));
      ASSERT_TRUE(clients.back()->connected());
      if (i % 3 == 1) clients.back()->say("GET /preview.jpg HT");
      if (i % 3 == 2) clients.back()->say("GET /preview.jpg HTTP/1.1\r\nHost: localhost\r\n\r\n");
    }
    for (int i = 0; i < 1000; ++i) server.publish(state);
    EXPECT_EQ(get(server, "/healthz")->status, 200);
  }
}

/// Clients that send a byte every half second, for as long as it lives.
class SlowClients {
 public:
  SlowClients(int port, int n) : port_(port) {
    for (int i = 0; i < n; ++i) clients_.push_back(std::make_unique<RawClient>(port));
    thread_ = std::jthread([this](const std::stop_token& stop) {
      const std::string request = "GET /status.json HTTP/1.1\r\nX-Slow: " + std::string(4000, 'x');
      for (std::size_t byte = 0; !stop.stop_requested(); ++byte) {
        for (auto& client : clients_) {
          if (!client->say(request.substr(byte % request.size(), 1)))
            client = std::make_unique<RawClient>(port_);  // shown the door: it comes again
        }
        for (int i = 0; i < 50 && !stop.stop_requested(); ++i) std::this_thread::sleep_for(milliseconds(10));
      }
    });
  }

 private:
  int port_;
  std::vector<std::unique_ptr<RawClient>> clients_;
  std::jthread thread_;
};

TEST(MonitorServer, ClientsThatSendAByteNowAndThenCloseThePageForNobody) {
  for (const int n : {4, 40, 400}) {
    MonitorServer server({.port = 0, .token = kToken});
    server.publish(sample_monitor_state());
    const SlowClients slow(server.port(), n);
    for (int look = 0; look < 6; ++look) {
      const auto status = get(server, std::string("/status.json?token=") + kToken);
      ASSERT_TRUE(status) << n << " slow clients: " << httplib::to_string(status.error());
      EXPECT_EQ(status->status, 200);
      std::this_thread::sleep_for(milliseconds(300));
    }
  }
}

TEST(MonitorServer, ARequestHasOnlySoMuchTime) {
  MonitorServer server({.port = 0});
  const RawClient slow(server.port());
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) {
    slow.say("G");
    if (slow.closed(milliseconds(200))) break;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(15)) << "20 s of bytes were listened to";
}

TEST(MonitorServer, AskingForThousandsOfRangesBringsNoMoreThanThePicture) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.preview_jpeg = std::make_shared<const std::string>(std::string(20000, 'x'));
  server.publish(state);
  std::string ranges = "bytes=0-";
  for (int i = 0; i < 1500; ++i) ranges += ",0-";
  const std::string whole = "GET /preview.jpg HTTP/1.1\r\nHost: localhost\r\n";
  for (const std::string& request :
       {whole + "Range: " + ranges + "\r\n\r\n", whole + "range: bytes=5-\r\n\r\n",
        whole + "Accept-Encoding: br, gzip\r\n\r\n", whole + "Expect: 100-continue\r\nContent-Length: 9\r\n\r\n"}) {
    const RawClient client(server.port());
    client.say(request);
    const std::string answer = client.hears();
    EXPECT_THAT(answer, testing::StartsWith("HTTP/1.1 200"));
    EXPECT_LT(answer.size(), 21000u);
  }
}

TEST(MonitorServer, AHeaderWithoutAnEndIsRefused) {
  MonitorServer server({.port = 0});
  const RawClient client(server.port());
  client.say("GET /status.json HTTP/1.1\r\n");
  for (int i = 0; i < 500; ++i) client.say("X-More-" + std::to_string(i) + ": " + std::string(40, 'x') + "\r\n");
  EXPECT_THAT(client.hears(), testing::StartsWith("HTTP/1.1 431"));
}

TEST(MonitorServer, AHostThatIsNoneIsNamed) {
  for (const char* host : {"no.such.host.invalid", "192.0.2.77"}) {
    try {
      const MonitorServer server({.host = host, .port = 0, .token = kToken});
      FAIL() << host;
    } catch (const DeviceError& error) {
      EXPECT_THAT(error.what(), HasSubstr(host));
      EXPECT_THAT(error.what(), HasSubstr("address of this machine"));
    }
  }
}

TEST(MonitorServer, SurvivesNonsense) {
  MonitorServer server({.port = 0});
  for (const std::string& nonsense :
       {std::string("\0\xff\x16\x03\x01", 5), std::string("GET\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"),
        "GET /" + std::string(20000, 'a') + " HTTP/1.1\r\n\r\n",
        std::string("POST /status.json HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n")}) {
    const RawClient client(server.port());
    client.say(nonsense);
  }
  EXPECT_EQ(get(server, "/healthz")->status, 200);
  EXPECT_EQ(httplib::Client("127.0.0.1", server.port()).Post("/status.json", "x", "text/plain")->status, 404);
}

}  // namespace
}  // namespace sheen
