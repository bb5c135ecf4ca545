// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/model_desk.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>

#include "common/base/errors.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

// Those of live.js, and a picture of 30 a second.
constexpr milliseconds kPoll{250}, kBusy{100}, kAway{1000}, kPicture{33}, kAtOnce{0};
constexpr double kTurn_rad_s = 0.5, kAway_m = 0.5;

}  // namespace

ModelDesk::ModelDesk(int port, double begins_rad)
    : port_(port), begins_rad_(begins_rad), thread_([this](const std::stop_token& stop) {
        while (!stop.stop_requested()) std::this_thread::sleep_for(entered_ ? ask_for_changes() : ask_for_scene());
      }) {}

std::vector<double> ModelDesk::lags_ms() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return lags_ms_;
}

std::string ModelDesk::eye() const {
  const double azimuth = begins_rad_ + kTurn_rad_s * std::chrono::duration<double>(Clock::now() - begun_).count();
  return std::to_string(kAway_m * std::cos(azimuth)) + "," + std::to_string(kAway_m * std::sin(azimuth)) + ",0.3";
}

/// Empty: it is told to ask again.
std::string ModelDesk::get(const std::string& path) {
  const auto answer = httplib::Client("127.0.0.1", port_).Get(path);
  if (!answer || answer->status != 200) return {};
  bytes_ += answer->body.size();
  return answer->body;
}

ModelDesk::Rest ModelDesk::ask_for_scene() {
  const std::string answer = get("/model/scene");
  if (answer.empty()) return kAway;
  std::memcpy(&scene_, answer.data() + sizeof(scene_), sizeof(scene_));
  entered_ = true;
  changes_ = 0;
  more_ = false;
  return kAtOnce;
}

ModelDesk::Rest ModelDesk::ask_for_changes() {
  if (!more_) from_ = eye();
  const bool moved = !more_ && from_ != seen_;
  const std::string answer = get("/model/changes?scene=" + std::to_string(scene_) +
                                 "&changes=" + std::to_string(changes_) + "&eye=" + from_ + (moved ? "&moved=1" : ""));
  if (answer.empty()) return kBusy;
  std::array<std::uint32_t, 9> head{};  // LightFieldStream::changes_for
  std::memcpy(head.data(), answer.data(), sizeof(head));
  if (head[1] != scene_) {
    entered_ = false;
    return kAtOnce;
  }
  const bool told = head[4] > 0, seen = head[5] == 1;
  if (told) behind_since_ = std::min(behind_since_, Clock::now() - milliseconds(head[8]));
  changes_ = head[2];
  more_ = head[3] == 1;
  if (seen) seen_ = from_;
  if (more_) return kAtOnce;
  if (caught_up_ && told)
    lags_ms_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - behind_since_).count());
  behind_since_ = Clock::time_point::max();
  caught_up_ = true;
  return moved && !seen ? kPoll : kPicture;
}

StalledDesk::StalledDesk(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  constexpr int kLittle = 1;  // bytes, of which the kernel makes its least
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &kLittle, sizeof(kLittle));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const std::string request = "GET /model/scene HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    throw Error("the desk that stalls cannot ask");
}

StalledDesk::~StalledDesk() {
  ::close(socket_);
}

}  // namespace sheen
