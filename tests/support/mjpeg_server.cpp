// SPDX-License-Identifier: Apache-2.0
#include "tests/support/mjpeg_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLook{5};

bool readable(int socket) {
  pollfd one{socket, POLLIN, 0};
  return ::poll(&one, 1, kLook.count()) > 0;
}

std::string request_of(int caller, const std::stop_token& stop) {
  std::string request;
  while (!stop.stop_requested() && request.find("\r\n\r\n") == std::string::npos) {
    if (!readable(caller)) continue;
    char bytes[4096];
    const ssize_t count = ::recv(caller, bytes, sizeof bytes, 0);
    if (count <= 0) return {};
    request.append(bytes, std::size_t(count));
  }
  return request;
}

/// False when the caller has gone. One who does not read is waited for.
bool sent_all(int caller, std::string_view bytes, const std::stop_token& stop) {
  while (!bytes.empty()) {
    if (stop.stop_requested()) return false;
    const ssize_t count = ::send(caller, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count > 0) {
      bytes.remove_prefix(std::size_t(count));
      continue;
    }
    if (errno != EAGAIN && errno != EWOULDBLOCK) return false;
    pollfd one{caller, POLLOUT, 0};
    ::poll(&one, 1, kLook.count());
  }
  return true;
}

std::string base64(std::string_view text) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < text.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < text.size() ? std::uint8_t(text[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > text.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return out;
}

}  // namespace

MjpegServer::MjpegServer(Picture picture) : MjpegServer(std::move(picture), Options{}) {}

MjpegServer::MjpegServer(Picture picture, Options options)
    : picture_(std::move(picture)), options_(std::move(options)) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof here;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0 || ::listen(listener_, 8) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&here), &length) != 0)
    throw std::runtime_error("no port for a picture server");
  port_ = ntohs(here.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

MjpegServer::~MjpegServer() {
  thread_.request_stop();
  thread_.join();
  ::close(listener_);
}

std::string MjpegServer::address(const std::string& user) const {
  return "http://" + user + (user.empty() ? "" : "@") + "127.0.0.1:" + std::to_string(port_) + "/video";
}

void MjpegServer::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!readable(listener_)) continue;
    const int caller = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (caller < 0) continue;
    if (!refuses) {
      ++callers_;
      serve(caller, stop);
    }
    ::close(caller);
  }
}

bool MjpegServer::lets_in(const std::string& request) const {
  return options_.user_and_password.empty() ||
         request.find("Authorization: Basic " + base64(options_.user_and_password)) != std::string::npos;
}

void MjpegServer::serve(int caller, const std::stop_token& stop) {
  const std::string request = request_of(caller, stop);
  if (!lets_in(request)) {
    sent_all(caller,
             "HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"camera\"\r\nContent-Length: 0\r\n"
             "Connection: close\r\n\r\n",
             stop);
    return;
  }
  std::string head = "HTTP/1.1 " + options_.status + "\r\nContent-Type: " + options_.content_type +
                     "\r\nConnection: close\r\n\r\n" + options_.body;
  if (!sent_all(caller, head, stop) || !options_.body.empty() || options_.status.substr(0, 3) != "200") return;
  auto next = std::chrono::steady_clock::now();
  while (!stop.stop_requested() && !refuses && !hangs_up.exchange(false)) {
    if (silent || std::chrono::steady_clock::now() < next) {
      std::this_thread::sleep_for(milliseconds(1));
      continue;
    }
    next += options_.between;
    const std::string picture = picture_(sent_);
    const std::string length =
        options_.states_lengths ? "Content-Length: " + std::to_string(picture.size()) + "\r\n" : "";
    if (!sent_all(caller, "--picture\r\nContent-Type: image/jpeg\r\n" + length + "\r\n" + picture + "\r\n", stop))
      return;
    ++sent_;
  }
}

}  // namespace sheen::testing
