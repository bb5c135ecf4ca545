// SPDX-License-Identifier: Apache-2.0
#include "tests/support/loopback_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

namespace sheen::testing {
namespace {

constexpr int kLook_ms = 5;

bool readable(int socket) {
  pollfd one{socket, POLLIN, 0};
  return ::poll(&one, 1, kLook_ms) > 0;
}

}  // namespace

int listen_on_loopback(int& port) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof here;
  if (::bind(listener, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0 || ::listen(listener, 8) != 0 ||
      ::getsockname(listener, reinterpret_cast<sockaddr*>(&here), &length) != 0)
    throw std::runtime_error("no port for a server");
  port = ntohs(here.sin_port);
  return listener;
}

void close_socket(int socket) {
  ::close(socket);
}

void serve_callers(int listener, const std::stop_token& stop, const std::function<void(int)>& serve) {
  while (!stop.stop_requested()) {
    if (!readable(listener)) continue;
    const int caller = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    if (caller < 0) continue;
    serve(caller);
    ::close(caller);
  }
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
    ::poll(&one, 1, kLook_ms);
  }
  return true;
}

}  // namespace sheen::testing
