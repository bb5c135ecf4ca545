// SPDX-License-Identifier: Apache-2.0
#include "tests/support/cutting_relay.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>

namespace sheen::testing {
namespace {

constexpr int kPoll_ms = 5;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void close_with_reset(int socket) {
  const linger at_once{1, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  ::close(socket);
}

}  // namespace

CuttingRelay::CuttingRelay(int called_port, Victim victim)
    : called_port_(called_port), victim_(victim), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size);
  ::listen(listener_, 8);
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  port_ = ntohs(address.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::size_t CuttingRelay::held() const {
  const std::lock_guard lock(mutex_);
  return held_.size();
}

void CuttingRelay::cut() {
  cuts_ = true;
  cuts_.wait(true);
}

void CuttingRelay::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd waiting{listener_, POLLIN, 0};
    if (cuts_.exchange(false)) cuts_.notify_all();  // nobody is connected
    if (::poll(&waiting, 1, kPoll_ms) < 1) continue;
    const int caller = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    const int called = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(called_port_);
    if (::connect(called, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      connected_ = true;
      carry(caller, called, stop);
      connected_ = false;
    }
    close_with_reset(caller);
    close_with_reset(called);
    const std::lock_guard lock(mutex_);
    held_.clear();
    holds_ = false;
    if (cuts_.exchange(false)) cuts_.notify_all();
  }
  ::close(listener_);
}

/// Until one end hangs up, or the connection is to be cut.
void CuttingRelay::carry(int caller, int called, const std::stop_token& stop) {
  const int victim = victim_ == Victim::kCaller ? caller : called, other = victim == caller ? called : caller;
  std::array<std::uint8_t, 65536> piece;
  while (!stop.stop_requested()) {
    std::array<pollfd, 2> ends{{{other, POLLIN, 0}, {victim, POLLIN, 0}}};
    ::poll(ends.data(), ends.size(), kPoll_ms);
    for (const pollfd& end : ends) {
      if (end.revents == 0) continue;
      const ssize_t size = ::recv(end.fd, piece.data(), piece.size(), 0);
      if (size <= 0) return;
      const std::lock_guard lock(mutex_);
      if (end.fd == other && holds_)
        held_.insert(held_.end(), piece.begin(), piece.begin() + size);
      else
        (void)!::send(end.fd == other ? victim : other, piece.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL);
    }
    if (cuts_) {
      const std::lock_guard lock(mutex_);
      (void)!::send(victim, held_.data(), held_.size(), MSG_NOSIGNAL);
      return;
    }
  }
}

}  // namespace sheen::testing
