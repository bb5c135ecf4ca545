// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_server.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <sodium.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <future>
#include <limits>
#include <mutex>
#include <thread>

#include "common/bounded_queue.h"
#include "common/errors.h"
#include "reconstructor/monitor/metrics.h"
#include "reconstructor/monitor/status_json.h"
#include "reconstructor/monitor/status_page.h"

namespace sheen {
namespace {

using Clock = MonitorState::Clock;
using httplib::Request;
using httplib::Response;

constexpr std::size_t kThreads = 4;
constexpr std::size_t kWaitingConnections = 16;  // beyond these, the kernel's backlog
constexpr std::chrono::milliseconds kClientTimeout{1000};
constexpr std::chrono::milliseconds kStopPatience{800};
constexpr std::size_t kShortestToken = 16;

/// httplib's own pool keeps as many connections as come.
class BoundedThreads : public httplib::TaskQueue {
 public:
  BoundedThreads() : tasks_(kWaitingConnections) {
    for (std::size_t i = 0; i < kThreads; ++i)
      threads_.emplace_back([this] {
        while (std::optional<std::function<void()>> task = tasks_.pop()) (*task)();
      });
  }
  void enqueue(std::function<void()> task) override { tasks_.push(std::move(task)); }
  void shutdown() override {
    tasks_.close();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  BoundedQueue<std::function<void()>> tasks_;
  std::vector<std::thread> threads_;
};

bool is_loopback(const std::string& host) {
  in_addr v4{};
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  return host == "localhost" || host == "::1" || host == "[::1]";
}

std::string without_port(const std::string& host) {
  const std::size_t colon = host.rfind(':');
  return colon == std::string::npos || host.ends_with("]") ? host : host.substr(0, colon);
}

bool same_secret(const std::string& a, const std::string& b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

void require_valid(const MonitorOptions& options) {
  if (options.port < 0 || options.port > 65535)
    throw ConfigError("monitor port " + std::to_string(options.port) + " is none; give one from 1 to 65535, or 0");
  if (!is_loopback(options.host) && options.token.empty())
    throw ConfigError("the monitor page on " + options.host +
                      " could be seen by others: give it a token, or keep it on 127.0.0.1");
  if (!options.token.empty() && options.token.size() < kShortestToken)
    throw ConfigError("the monitor's token needs at least " + std::to_string(kShortestToken) + " characters");
}

struct Published {
  MonitorState state;
  PictureVersions pictures;
  Clock::time_point when;
};

}  // namespace

struct MonitorServer::Impl {
  MonitorOptions options;
  httplib::Server http;
  std::thread listener;
  std::future<void> listener_done;

  mutable std::mutex mutex;
  std::shared_ptr<const Published> published =
      std::make_shared<const Published>(Published{.state = {}, .pictures = {}, .when = Clock::now()});

  std::shared_ptr<const Published> latest() const {
    const std::lock_guard lock(mutex);
    return published;
  }

  bool refused(const Request& request, Response& response) const;
  void add_routes();
  void listen();
};

bool MonitorServer::Impl::refused(const Request& request, Response& response) const {
  response.set_header("Cache-Control", "no-store");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("Content-Security-Policy",
                      "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; "
                      "img-src 'self' data:; frame-ancestors 'none'");
  if (options.token.empty()) {
    if (is_loopback(without_port(request.get_header_value("Host")))) return false;
    response.status = 403;
    response.set_content("This page answers to 127.0.0.1 and localhost only.\n", "text/plain");
    return true;
  }
  constexpr std::string_view kBearer = "Bearer ";
  const std::string header = request.get_header_value("Authorization");
  if (header.starts_with(kBearer) && same_secret(header.substr(kBearer.size()), options.token)) return false;
  if (same_secret(request.get_param_value("token"), options.token)) return false;
  response.status = 401;
  response.set_header("WWW-Authenticate", "Bearer realm=\"sheen\"");
  response.set_content("A token is needed: \"Authorization: Bearer TOKEN\", or ?token=TOKEN in the address.\n",
                       "text/plain");
  return true;
}

void MonitorServer::Impl::add_routes() {
  http.set_pre_routing_handler([this](const Request& request, Response& response) {
    return refused(request, response) ? httplib::Server::HandlerResponse::Handled
                                      : httplib::Server::HandlerResponse::Unhandled;
  });
  http.Get("/", [](const Request&, Response& response) {
    const std::string_view page = status_page();
    response.set_content(page.data(), page.size(), "text/html; charset=utf-8");
  });
  http.Get("/status.json", [this](const Request&, Response& response) {
    const std::shared_ptr<const Published> now = latest();
    const auto age = [](Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); };
    const double frame_age_s =
        now->state.last_frame ? age(*now->state.last_frame) : std::numeric_limits<double>::quiet_NaN();
    response.set_content(status_json(now->state, capture_state(now->state, now->when, Clock::now()), age(now->when),
                                     frame_age_s, now->pictures),
                         "application/json");
  });
  http.Get("/metrics", [this](const Request&, Response& response) {
    const std::shared_ptr<const Published> now = latest();
    response.set_content(metrics_text(now->state, capture_state(now->state, now->when, Clock::now()), Clock::now()),
                         "text/plain; version=0.0.4; charset=utf-8");
  });
  const auto picture = [this](const std::shared_ptr<const std::string> MonitorState::*jpeg) {
    return [this, jpeg](const Request&, Response& response) {
      const std::shared_ptr<const Published> now = latest();
      if (const auto& bytes = now->state.*jpeg) return response.set_content(*bytes, "image/jpeg");
      response.status = 404;
      response.set_content("There is no picture yet.\n", "text/plain");
    };
  };
  http.Get("/preview.jpg", picture(&MonitorState::preview_jpeg));
  http.Get("/camera.jpg", picture(&MonitorState::camera_jpeg));
  http.Get("/healthz", [this](const Request&, Response& response) {
    const std::shared_ptr<const Published> now = latest();
    const CaptureState state = capture_state(now->state, now->when, Clock::now());
    if (state == CaptureState::kFailed || state == CaptureState::kStalled) response.status = 503;
    response.set_content(std::string(to_string(state)) + "\n", "text/plain");
  });
  http.set_error_handler([](const Request&, Response& response) {
    if (response.status == 404 && response.body.empty())
      response.set_content("There are / /status.json /metrics /preview.jpg /camera.jpg /healthz\n", "text/plain");
  });
}

void MonitorServer::Impl::listen() {
  http.new_task_queue = [] { return new BoundedThreads; };  // httplib owns it
  http.set_keep_alive_max_count(1);                         // a thread is a client's for one answer
  http.set_read_timeout(kClientTimeout);
  http.set_write_timeout(kClientTimeout);
  http.set_payload_max_length(1024);
  http.set_socket_options([](int socket) {
    const int yes = 1;  // and not SO_REUSEPORT, with which two programs share a port unnoticed
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  errno = 0;
  bool bound = false;
  if (options.port == 0) {
    options.port = http.bind_to_any_port(options.host);
    bound = options.port > 0;
  } else {
    bound = http.bind_to_port(options.host, options.port);
  }
  if (!bound) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "the address is not known";
    throw DeviceError("monitor page: cannot listen on " + options.host + " port " + std::to_string(options.port) +
                      " (" + reason + "); stop the program that has it, or choose another port or address");
  }
}

MonitorServer::MonitorServer(const MonitorOptions& options) : impl_(std::make_shared<Impl>()) {
  require_valid(options);
  if (sodium_init() < 0) throw DeviceError("libsodium could not be initialised");
  impl_->options = options;
  impl_->add_routes();
  impl_->listen();
  std::promise<void> done;
  impl_->listener_done = done.get_future();
  impl_->listener = std::thread([impl = impl_, finished = std::move(done)]() mutable {
    impl->http.listen_after_bind();
    finished.set_value();
  });
  // Until it runs, httplib would overlook a call of stop().
  while (!impl_->http.is_running() &&
         impl_->listener_done.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) {
  }
}

MonitorServer::~MonitorServer() {
  impl_->http.stop();
  // A client that sends its request byte by byte could keep its thread; what that uses stays alive with it.
  if (impl_->listener_done.wait_for(kStopPatience) == std::future_status::ready)
    impl_->listener.join();
  else
    impl_->listener.detach();
}

void MonitorServer::publish(MonitorState state) {
  const std::shared_ptr<const Published> before = impl_->latest();
  auto next = std::make_shared<Published>();
  next->pictures = before->pictures;
  if (state.preview_jpeg != before->state.preview_jpeg) ++next->pictures.preview;
  if (state.camera_jpeg != before->state.camera_jpeg) ++next->pictures.camera;
  next->state = std::move(state);
  next->when = Clock::now();
  const std::lock_guard lock(impl_->mutex);
  impl_->published = std::move(next);
}

int MonitorServer::port() const {
  return impl_->options.port;
}

std::string MonitorServer::url() const {
  const std::string& host = impl_->options.host;
  const std::string shown = host.find(':') == std::string::npos ? host : "[" + host + "]";
  return "http://" + shown + ":" + std::to_string(impl_->options.port) + "/";
}

}  // namespace sheen
