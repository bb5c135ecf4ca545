// SPDX-License-Identifier: Apache-2.0
#include "tests/support/mjpeg_server.h"

#include <utility>

#include "tests/support/loopback_socket.h"

namespace sheen::testing {
namespace {

using std::chrono::milliseconds;

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
    : picture_(std::move(picture)), options_(std::move(options)), listener_(listen_on_loopback(port_)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

MjpegServer::~MjpegServer() {
  thread_.request_stop();
  thread_.join();
  close_socket(listener_);
}

std::string MjpegServer::address(const std::string& user) const {
  return "http://" + user + (user.empty() ? "" : "@") + "127.0.0.1:" + std::to_string(port_) + "/video";
}

void MjpegServer::run(const std::stop_token& stop) {
  serve_callers(listener_, stop, [&](int caller) {
    if (refuses) return;
    ++callers_;
    serve(caller, stop);
  });
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
