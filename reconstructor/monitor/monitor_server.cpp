// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_server.h"

#include <httplib.h>
#include <sodium.h>
#include <strings.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>

#include "common/base/errors.h"
#include "common/base/sparing_log.h"
#include "common/http/http_connections.h"
#include "common/http/loopback_host.h"
#include "reconstructor/monitor/metrics.h"
#include "reconstructor/monitor/status_json.h"
#include "reconstructor/monitor/status_page.h"
#include "reconstructor/monitor/token_guesses.h"

namespace sheen {
namespace {

using Clock = MonitorState::Clock;
using httplib::Request;
using httplib::Response;

constexpr std::size_t kShortestToken = 16, kLongestNote = 1000;
constexpr const char* kModelPath = "/model/";  // of a page that stands in a frame of the status page

/// The lines of a request that the page has a use for. What else clients send is work without an end: byte ranges of a
/// picture by the thousand, encodings, bodies.
std::string essential(const std::string& request) {
  std::string kept;
  for (std::size_t begin = 0; begin < request.size();) {
    const std::size_t end = request.find("\r\n", begin) + 2;
    const std::string_view line = std::string_view(request).substr(begin, end - begin);
    const auto is = [line](std::string_view name) {
      return line.size() > name.size() && line[name.size()] == ':' &&
             ::strncasecmp(line.data(), name.data(), name.size()) == 0;
    };
    if (begin == 0 || line.size() == 2 || is("Host") || is("Authorization")) kept += line;
    begin = end;
  }
  return kept;
}

/// A request that is there in full, and the answer as it is written.
class TextStream : public httplib::Stream {
 public:
  TextStream(std::string request, std::string address) : request_(std::move(request)), address_(std::move(address)) {}
  std::string take_answer() { return std::move(answer_); }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    const std::size_t n = request_.copy(to, size, read_);
    read_ += n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* from, std::size_t size) override {
    answer_.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int&) const override { ip = address_; }
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return 0; }

 private:
  std::string request_, address_, answer_;
  std::size_t read_ = 0;
};

/// httplib as a parser and a router: its own connections keep a thread for each client, however slow.
class Router : public httplib::Server {
 public:
  std::string answer(const std::string& request, const std::string& address) {
    TextStream stream(essential(request), address);
    bool closed = true;
    process_request(stream, closed, closed, nullptr);
    return stream.take_answer();
  }
};

/// Of the header, else of the address.
std::string token_of(const Request& request) {
  constexpr std::string_view kBearer = "Bearer ";
  const std::string header = request.get_header_value("Authorization");
  return header.starts_with(kBearer) ? header.substr(kBearer.size()) : request.get_param_value("token");
}

void require_valid(const MonitorOptions& options) {
  if (options.port < 0 || options.port > 65535)
    throw ConfigError("monitor port " + std::to_string(options.port) +
                      " is not a port; give one from 1 to 65535, or 0");
  if (!is_loopback_host(options.host) && options.token.empty())
    throw ConfigError("the monitor page on " + options.host +
                      " could be seen by others: give it a token, or keep it on 127.0.0.1");
  for (const std::string& token : {options.token, options.steer_token})
    if (!token.empty() && token.size() < kShortestToken)
      throw ConfigError("the monitor's token needs at least " + std::to_string(kShortestToken) + " characters");
  if (!options.steer_token.empty() && options.token == options.steer_token)
    throw ConfigError("the token for watching and that for steering are one: whoever watches could steer");
}

struct Published {
  MonitorState state;
  PictureVersions pictures;
  std::uint64_t pictures_so_far = 0;  ///< a number is never that of two pictures
  Clock::time_point when;
};

}  // namespace

struct MonitorServer::Impl {
  MonitorOptions options;
  Router http;

  mutable std::mutex mutex;
  std::shared_ptr<const Published> published =
      std::make_shared<const Published>(Published{.state = {}, .pictures = {}, .when = Clock::now()});
  SparingLog log{"monitor"};
  std::optional<TokenGuesses> guesses;         // used by the connections' thread only
  std::optional<HttpConnections> connections;  // last: it ends before what it answers from

  std::shared_ptr<const Published> latest() const {
    const std::lock_guard lock(mutex);
    return published;
  }

  bool may_steer(const Request& request) const {
    return !options.steer_token.empty() && same_secret(token_of(request), options.steer_token);
  }
  bool refused(const Request& request, Response& response);
  void steer(const Request& request, Response& response) const;
  void add_model_routes();
  void add_routes();
};

bool MonitorServer::Impl::refused(const Request& request, Response& response) {
  response.set_header("Cache-Control", "no-store");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("Content-Security-Policy",
                      "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; "
                      "img-src 'self' data:; frame-src 'self'; frame-ancestors " +
                          std::string(request.path == kModelPath ? "'self'" : "'none'"));
  if (options.token.empty() && (options.steer_token.empty() || token_of(request).empty())) {
    if (names_loopback(request.get_header_value("Host"))) return false;
    response.status = 403;
    response.set_content("This page answers to 127.0.0.1 and localhost only.\n", "text/plain");
    return true;
  }
  const TokenGuesses::Verdict verdict = guesses->judge(request.remote_addr, token_of(request), Clock::now());
  if (verdict == TokenGuesses::Verdict::kRight) return false;
  if (verdict == TokenGuesses::Verdict::kNotLookedAt) {
    response.status = 429;
    response.set_header("Retry-After", "10");
    response.set_content("Too many wrong tokens came from this address: try again in a while.\n", "text/plain");
    return true;
  }
  response.status = 401;
  response.set_header("WWW-Authenticate", "Bearer realm=\"sheen\"");
  response.set_content("A token is needed: \"Authorization: Bearer TOKEN\", or ?token=TOKEN in the address.\n",
                       "text/plain");
  return true;
}

void MonitorServer::Impl::steer(const Request& request, Response& response) const {
  const auto answer = [&response](int status, const std::string& words) {
    response.status = status;
    response.set_content(words + "\n", "text/plain; charset=utf-8");
  };
  if (!may_steer(request) || !request.has_header("Authorization"))
    return answer(403,
                  "Who watches may not steer: \"Authorization: Bearer TOKEN\" with the token for steering is needed.");
  const auto action = steer_action(request.get_param_value("what"));
  if (!action) return answer(400, "what is undo, hold-out, pause, go-on, note or finish.");
  std::string text = request.get_param_value("text");
  if (text.size() > kLongestNote) return answer(400, "A note has at most " + std::to_string(kLongestNote) + " bytes.");
  if (text.empty() && *action == SteerRequest::Action::kNote) return answer(400, "text is missing.");
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  const std::string why_not = options.steer({*action, std::move(text), request.remote_addr});
  answer(why_not.empty() ? 202 : 503, why_not.empty() ? "asked for" : why_not);
}

void MonitorServer::Impl::add_model_routes() {
  if (!options.model) return;
  const auto give = [](ServedModel::Answer answer, Response& response) {
    response.status = answer.status;
    response.set_content(answer.bytes, answer.status == 200 ? "application/octet-stream" : "text/plain");
  };
  http.Get(kModelPath, [this](const Request&, Response& response) {
    const std::string_view page = options.model->page();
    response.set_content(page.data(), page.size(), "text/html; charset=utf-8");
  });
  http.Get("/model/scene",
           [this, give](const Request&, Response& response) { give(options.model->scene(), response); });
  http.Get("/model/changes", [this, give](const Request& request, Response& response) {
    const auto said = [&request](const char* name) { return request.get_param_value(name); };
    const auto question = desk_question(said("scene"), said("changes"), said("eye"), request.has_param("moved"));
    give(question ? options.model->changes_for(*question)
                  : ServedModel::Answer{400, "scene and changes are whole numbers, eye is x,y,z in metres.\n"},
         response);
  });
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
  http.Get("/status.json", [this](const Request& request, Response& response) {
    const std::shared_ptr<const Published> now = latest();
    const auto age = [](Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); };
    const double frame_age_s =
        now->state.last_frame ? age(*now->state.last_frame) : std::numeric_limits<double>::quiet_NaN();
    PictureVersions pictures = now->pictures;
    pictures.model_page = options.model && options.model->there();
    response.set_content(status_json(now->state, capture_state(now->state, now->when, Clock::now()), age(now->when),
                                     frame_age_s, pictures, may_steer(request)),
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
  http.Get("/shape.jpg", picture(&MonitorState::shape_jpeg));
  http.Get("/camera.jpg", picture(&MonitorState::camera_jpeg));
  http.Get("/healthz", [this](const Request&, Response& response) {
    const std::shared_ptr<const Published> now = latest();
    const CaptureState state = capture_state(now->state, now->when, Clock::now());
    if (state == CaptureState::kFailed || state == CaptureState::kStalled) response.status = 503;
    response.set_content(std::string(to_string(state)) + "\n", "text/plain");
  });
  add_model_routes();
  http.Post("/steer", [this](const Request& request, Response& response) { steer(request, response); });
  http.set_error_handler([](const Request&, Response& response) {
    if (response.status == 404 && response.body.empty())
      response.set_content("There are / /status.json /metrics /preview.jpg /shape.jpg /camera.jpg /model/ /healthz\n",
                           "text/plain");
  });
}

MonitorServer::MonitorServer(const MonitorOptions& options) : impl_(std::make_unique<Impl>()) {
  require_valid(options);
  if (sodium_init() < 0) throw DeviceError("libsodium could not be initialised");
  impl_->options = options;
  impl_->guesses.emplace(std::vector{options.token, options.steer_token},
                         [impl = impl_.get()](const std::string& address, const std::string& message) {
                           impl->log.tell(address, message);
                         });
  impl_->add_routes();
  impl_->connections.emplace(options.host, options.port,
                             [impl = impl_.get()](const std::string& request, const std::string& address) {
                               return impl->http.answer(request, address);
                             });
}

MonitorServer::~MonitorServer() = default;

void MonitorServer::publish(MonitorState state) {
  const std::shared_ptr<const Published> before = impl_->latest();
  auto next = std::make_shared<Published>();
  next->pictures = before->pictures;
  next->pictures_so_far = before->pictures_so_far;
  const auto number = [&](const auto& jpeg, const auto& jpeg_before, auto& picture) {
    if (jpeg != jpeg_before) picture = jpeg ? ++next->pictures_so_far : 0;
  };
  number(state.preview_jpeg, before->state.preview_jpeg, next->pictures.preview);
  number(state.shape_jpeg, before->state.shape_jpeg, next->pictures.shape);
  number(state.camera_jpeg, before->state.camera_jpeg, next->pictures.camera);
  next->state = std::move(state);
  next->when = Clock::now();
  const std::lock_guard lock(impl_->mutex);
  impl_->published = std::move(next);
}

int MonitorServer::port() const {
  return impl_->connections->port();
}

std::string MonitorServer::url() const {
  const std::string& host = impl_->options.host;
  const bool bare = host.find(':') == std::string::npos || host.starts_with("[");
  const std::string shown = bare ? host : "[" + host + "]";
  return "http://" + shown + ":" + std::to_string(port()) + "/";
}

}  // namespace sheen
