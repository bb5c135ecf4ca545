// SPDX-License-Identifier: Apache-2.0
#include "common/http/http_connections.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <list>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/sparing_log.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kTooLong =
    "HTTP/1.1 431 Request Header Fields Too Large\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";
constexpr std::chrono::milliseconds kAcceptPause{100};  // after a failure to accept, for want of descriptors say

/// A file descriptor and its end.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

/// An address without its port, as a person writes it.
std::string text_of(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool v4 = address.ss_family == AF_INET;
  const void* const bytes = v4 ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in&>(address).sin_addr)
                               : &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  ::inet_ntop(address.ss_family, bytes, text.data(), text.size());
  return text.data();
}

int port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET ? reinterpret_cast<const sockaddr_in&>(address).sin_port
                                            : reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
}

Descriptor listen_on(const std::string& host, int port) {
  const std::string where = "monitor page: cannot listen on " + host + " port " + std::to_string(port) + ": ";
  const bool bracketed = host.starts_with("[") && host.ends_with("]");
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo((bracketed ? host.substr(1, host.size() - 2) : host).c_str(),
                                      std::to_string(port).c_str(), &hints, &found);
      error != 0)
    throw DeviceError(where + ::gai_strerror(error) + "; give an address of this machine");
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  int reason = 0;
  for (const addrinfo* a = addresses.get(); a; a = a->ai_next) {
    Descriptor socket(::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol));
    const int yes = 1;  // and not SO_REUSEPORT, with which two programs share a port unnoticed
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    if (::bind(socket.get(), a->ai_addr, a->ai_addrlen) == 0 && ::listen(socket.get(), SOMAXCONN) == 0) return socket;
    reason = errno;
  }
  throw DeviceError(where + std::strerror(reason) +
                    (reason == EADDRNOTAVAIL ? "; it is not an address of this machine"
                                             : "; stop the program that has it, or choose another port or address"));
}

struct Connection {
  Descriptor socket;
  std::string address;
  Clock::time_point deadline;
  std::string request;
  std::string answer;
  std::size_t sent = 0;
  enum class Step { kRequest, kAnswer, kFarewell } step = Step::kRequest;

  short wanted() const { return step == Step::kAnswer ? POLLOUT : POLLIN; }
};

}  // namespace

struct HttpConnections::Impl {
  Impl(const std::string& host, int port, Answer a, const HttpLimits& l)
      : answer(std::move(a)), limits(l), listener(listen_on(host, port)), wake(::eventfd(0, EFD_CLOEXEC)) {
    const auto tell = [this](const std::exception_ptr& error) { begin_anew(words_of(error)); };
    thread = guarded_thread(
        [this, tell](const std::stop_token& stop) {
          ::pthread_setname_np(::pthread_self(), "http");  // so that what it costs can be told from the rest
          while (!stop.stop_requested()) guarded([this] { serve_those_that_are_ready(); }, tell);
        },
        tell);
  }
  ~Impl() {
    thread.request_stop();
    const std::uint64_t one = 1;
    (void)!::write(wake.get(), &one, sizeof(one));
    thread.join();
  }

  void serve_those_that_are_ready();
  void begin_anew(const std::string& after);
  int patience() const;
  void accept_all();
  void make_room_for(const std::string& address);
  bool go_on(Connection& connection) const;
  bool read_request(Connection& connection) const;
  void send_answer(Connection& connection, std::string text) const;

  Answer answer;
  HttpLimits limits;
  Descriptor listener, wake;
  std::list<Connection> connections;  ///< the oldest first
  Clock::time_point accept_from;
  SparingLog log{"monitor"};
  std::jthread thread;
};

void HttpConnections::Impl::serve_those_that_are_ready() {
  std::vector<pollfd> polled{{wake.get(), POLLIN, 0}, {Clock::now() >= accept_from ? listener.get() : -1, POLLIN, 0}};
  for (const Connection& c : connections) polled.push_back({c.socket.get(), c.wanted(), 0});
  if (::poll(polled.data(), polled.size(), patience()) < 0 && errno != EINTR) accept_from = Clock::now() + kAcceptPause;
  auto ready = polled.begin() + 2;
  for (auto c = connections.begin(); c != connections.end(); ++ready) {
    const bool stays = ready->revents == 0 || go_on(*c);
    c = stays && Clock::now() < c->deadline ? std::next(c) : connections.erase(c);
  }
  if (polled[1].revents != 0) accept_all();
}

void HttpConnections::Impl::begin_anew(const std::string& after) {
  connections.clear();
  accept_from = Clock::now() + kAcceptPause;
  log.tell(after, "the page's connections were closed: " + after);
}

/// Milliseconds until something is due; -1: nothing is.
int HttpConnections::Impl::patience() const {
  const auto now = Clock::now();
  std::optional<Clock::time_point> due;
  if (now < accept_from) due = accept_from;
  for (const Connection& c : connections) due = std::min(due.value_or(c.deadline), c.deadline);
  if (!due) return -1;
  return static_cast<int>(std::max<std::int64_t>(0, (*due - now) / std::chrono::milliseconds(1) + 1));
}

void HttpConnections::Impl::accept_all() {
  for (;;) {
    sockaddr_storage from{};
    socklen_t size = sizeof(from);
    Descriptor socket(
        ::accept4(listener.get(), reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) {
      if (errno == EINTR || errno == ECONNABORTED) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) accept_from = Clock::now() + kAcceptPause;
      return;
    }
    std::string address = text_of(from);
    make_room_for(address);
    connections.push_back(
        {.socket = std::move(socket), .address = std::move(address), .deadline = Clock::now() + limits.request});
  }
}

void HttpConnections::Impl::make_room_for(const std::string& address) {
  const auto same = [&address](const Connection& c) { return c.address == address; };
  if (static_cast<std::size_t>(std::count_if(connections.begin(), connections.end(), same)) >=
      limits.connections_of_an_address)
    connections.erase(std::find_if(connections.begin(), connections.end(), same));
  if (connections.size() >= limits.connections) connections.pop_front();
}

/// Does what can be done without waiting; false when the connection is over.
bool HttpConnections::Impl::go_on(Connection& connection) const {
  if (connection.step == Connection::Step::kRequest && !read_request(connection)) return false;
  if (connection.step == Connection::Step::kAnswer) {
    const std::size_t left = connection.answer.size() - connection.sent;
    const ssize_t n = ::send(connection.socket.get(), connection.answer.data() + connection.sent, left, MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    connection.sent += static_cast<std::size_t>(n);
    if (connection.sent < connection.answer.size()) return true;
    // Closed at once, a client that has said more than was read would lose the answer.
    ::shutdown(connection.socket.get(), SHUT_WR);
    connection.answer = {};
    connection.step = Connection::Step::kFarewell;
    connection.deadline = Clock::now() + limits.farewell;
    return true;
  }
  if (connection.step == Connection::Step::kFarewell) {
    std::array<char, 4096> ignored;
    const ssize_t n = ::recv(connection.socket.get(), ignored.data(), ignored.size(), 0);
    return n > 0 || (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR));
  }
  return true;
}

bool HttpConnections::Impl::read_request(Connection& connection) const {
  std::array<char, 4096> piece;
  const ssize_t n = ::recv(connection.socket.get(), piece.data(), piece.size(), 0);
  if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  if (n == 0) return false;
  constexpr std::string_view kEnd = "\r\n\r\n";
  const std::size_t looked_at = connection.request.size() - std::min(connection.request.size(), kEnd.size() - 1);
  connection.request.append(piece.data(), static_cast<std::size_t>(n));
  const std::size_t end = connection.request.find(kEnd, looked_at);
  if (end != std::string::npos) {
    connection.request.resize(end + kEnd.size());
    try {
      send_answer(connection, answer(connection.request, connection.address));
    } catch (const std::exception&) {  // what one client asks must not end a capture
      return false;
    }
    return !connection.answer.empty();
  }
  if (connection.request.size() > limits.request_bytes) send_answer(connection, kTooLong);
  return true;
}

void HttpConnections::Impl::send_answer(Connection& connection, std::string text) const {
  connection.request = {};
  connection.answer = std::move(text);
  connection.step = Connection::Step::kAnswer;
  connection.deadline = Clock::now() + limits.answer;
}

HttpConnections::HttpConnections(const std::string& host, int port, Answer answer, const HttpLimits& limits)
    : impl_(std::make_unique<Impl>(host, port, std::move(answer), limits)) {}
HttpConnections::~HttpConnections() = default;

int HttpConnections::port() const {
  return port_of(impl_->listener.get());
}

}  // namespace sheen
