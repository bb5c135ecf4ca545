// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/tcp_relay.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <vector>

namespace sheen {
namespace {

constexpr int kLookMs = 5;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int connected_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return socket;
  ::close(socket);
  return -1;
}

bool send_all(int socket, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = ::send(socket, bytes, size, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

/// Two sockets; what comes out of one goes into the other.
struct Pair {
  int ends[2];
  /// What waits at one end, if anything does; false when that end is closed.
  bool pass(int from) const {
    char bytes[1 << 16];
    const ssize_t size = ::recv(ends[from], bytes, sizeof bytes, 0);
    return size > 0 && send_all(ends[1 - from], bytes, static_cast<std::size_t>(size));
  }
  void close() const {
    ::close(ends[0]);
    ::close(ends[1]);
  }
};

}  // namespace

TcpRelay::TcpRelay(const std::string& target)
    : target_port_(std::stoi(target.substr(target.rfind(':') + 1))),
      listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 16) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::runtime_error("no relay on 127.0.0.1");
  port_ = ntohs(address.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

TcpRelay::~TcpRelay() {
  thread_.request_stop();
  thread_.join();
  ::close(listener_);
}

void TcpRelay::run(const std::stop_token& stop) {
  std::vector<Pair> pairs;
  while (!stop.stop_requested()) {
    std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
    for (const Pair& pair : pairs)
      for (const int end : pair.ends) waiting.push_back({end, POLLIN, 0});
    if (cut_ || ::poll(waiting.data(), waiting.size(), kLookMs) <= 0) {
      if (cut_) std::this_thread::sleep_for(std::chrono::milliseconds(kLookMs));
      continue;
    }
    for (std::size_t i = pairs.size(); i-- > 0;)
      for (int from = 0; from < 2; ++from)
        if (waiting[1 + 2 * i + static_cast<std::size_t>(from)].revents != 0 && !pairs[i].pass(from)) {
          pairs[i].close();
          pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(i));
          break;
        }
    if (waiting[0].revents & POLLIN) {
      const int near = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const int far = connected_to(target_port_);
      if (near >= 0 && far >= 0)
        pairs.push_back({{near, far}});
      else
        for (const int socket : {near, far})
          if (socket >= 0) ::close(socket);
    }
  }
  for (const Pair& pair : pairs) pair.close();
}

}  // namespace sheen
