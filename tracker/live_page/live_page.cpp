// SPDX-License-Identifier: Apache-2.0
#include "tracker/live_page/live_page.h"

#include <strings.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/http/http_connections.h"
#include "common/http/loopback_host.h"
#include "common/image/image_io.h"
#include "tracker/live_page/page_text.h"
#include "tracker/preview.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBetween{100};  // two pictures
constexpr std::chrono::seconds kLooking{3};         // since the last question
constexpr int kMostWidth = 960, kMiddle = 320;      // pixels
constexpr int kJpegQuality = 88;

/// Every so many pixels: quick, and no worse than what a screen makes of too large a picture.
ImageU8 thinned(const ImageU8& image, int step) {
  ImageU8 small(image.width() / step, image.height() / step, image.channels());
  for (int y = 0; y < small.height(); ++y)
    for (int x = 0; x < small.width(); ++x)
      std::copy_n(image.pixel(x * step, y * step), image.channels(), small.pixel(x, y));
  return small;
}

ImageU8 middle_of(const ImageU8& image) {
  const int width = std::min(kMiddle, image.width()), height = std::min(kMiddle, image.height());
  ImageU8 middle(width, height, image.channels());
  for (int y = 0; y < height; ++y)
    std::copy_n(image.pixel((image.width() - width) / 2, (image.height() - height) / 2 + y), width * image.channels(),
                middle.pixel(0, y));
  return middle;
}

std::string jpeg(const ImageU8& image) {
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, kJpegQuality);
  return {bytes.begin(), bytes.end()};
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// What the page shows, as it is sent.
struct Shown {
  std::uint64_t number = 0;   ///< counts what was shown; 0: there is nothing yet
  int width = 0, height = 0;  ///< of the camera's image
  std::string look, picture, middle;
};

std::string answer_of(const char* status, const char* type, std::string_view body) {
  std::string answer = std::string("HTTP/1.1 ") + status + "\r\nContent-Type: " + type +
                       "\r\nContent-Length: " + std::to_string(body.size()) +
                       "\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer"
                       "\r\nContent-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; "
                       "script-src 'unsafe-inline'; connect-src 'self'; img-src 'self' data:; frame-ancestors 'none'"
                       "\r\nConnection: close\r\n\r\n";
  answer += body;
  return answer;
}

/// Of a request header; empty: it is not there.
std::string field_of(const std::string& request, std::string_view name) {
  for (std::size_t begin = request.find("\r\n") + 2; begin < request.size();) {
    const std::size_t end = request.find("\r\n", begin);
    const std::string_view line = std::string_view(request).substr(begin, end - begin);
    if (line.size() > name.size() && line[name.size()] == ':' &&
        ::strncasecmp(line.data(), name.data(), name.size()) == 0) {
      const std::size_t value = line.find_first_not_of(" \t", name.size() + 1);
      return value == std::string_view::npos ? std::string() : std::string(line.substr(value));
    }
    begin = end + 2;
  }
  return {};
}

}  // namespace

struct LivePage::Impl {
  explicit Impl(int port)
      : connections("127.0.0.1", port,
                    [this](const std::string& request, const std::string&) { return answer(request); }) {}

  std::string answer(const std::string& request);
  void replace(Shown next, const LiveWords& words);

  mutable std::mutex mutex;
  std::shared_ptr<const Shown> shown = std::make_shared<const Shown>();
  std::atomic<Clock::rep> looked_at{Clock::time_point::min().time_since_epoch().count()};
  Clock::time_point made_at = Clock::time_point::min();
  HttpConnections connections;  ///< last: it ends before what it answers from
};

std::string LivePage::Impl::answer(const std::string& request) {
  constexpr const char *kOk = "200 OK", *kText = "text/plain; charset=utf-8";
  if (!names_loopback(field_of(request, "Host")))
    return answer_of("403 Forbidden", kText, "This page answers to 127.0.0.1 and localhost only.\n");
  const std::string_view line = std::string_view(request).substr(0, request.find("\r\n"));
  if (!line.starts_with("GET ")) return answer_of("405 Method Not Allowed", kText, "Only GET is answered.\n");
  const std::string_view path = line.substr(4, line.find_first_of(" ?", 4) - 4);
  looked_at = Clock::now().time_since_epoch().count();
  std::shared_ptr<const Shown> now;
  {
    const std::lock_guard lock(mutex);
    now = shown;
  }
  if (path == "/") return answer_of(kOk, "text/html; charset=utf-8", live_page_text());
  if (path == "/look.json") return answer_of(kOk, "application/json", now->look.empty() ? "{}" : now->look);
  if (path == "/picture.jpg" && now->number > 0) return answer_of(kOk, "image/jpeg", now->picture);
  if (path == "/middle.jpg" && now->number > 0) return answer_of(kOk, "image/jpeg", now->middle);
  return answer_of("404 Not Found", kText, "There are / /look.json /picture.jpg /middle.jpg\n");
}

void LivePage::Impl::replace(Shown next, const LiveWords& words) {
  const std::lock_guard lock(mutex);
  next.number = shown->number + 1;
  next.look =
      nlohmann::json{{"number", next.number},  {"first", words.first},         {"well", words.well},
                     {"detail", words.detail}, {"focus", number(words.focus)}, {"best_focus", number(words.best_focus)},
                     {"width", next.width},    {"height", next.height}}
          .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  shown = std::make_shared<const Shown>(std::move(next));
}

LivePage::LivePage(int port) : impl_(std::make_unique<Impl>(port)) {}
LivePage::LivePage(LivePage&&) noexcept = default;
LivePage::~LivePage() = default;

void LivePage::show(const RawImage& image, const LiveWords& words) {
  const Clock::time_point now = Clock::now();
  const Clock::time_point looked_at{Clock::duration(impl_->looked_at.load())};
  if (looked_at + kLooking < now || impl_->made_at + kBetween > now) return;
  impl_->made_at = now;
  const ImageU8 picture = viewable(image);
  Shown next;
  next.width = image.width;
  next.height = image.height;
  next.picture = jpeg(thinned(picture, std::max(1, (picture.width() + kMostWidth - 1) / kMostWidth)));
  next.middle = jpeg(middle_of(picture));
  impl_->replace(std::move(next), words);
}

void LivePage::say(const LiveWords& words) {
  std::shared_ptr<const Shown> there;
  {
    const std::lock_guard lock(impl_->mutex);
    there = impl_->shown;
  }
  if (there->number > 0) impl_->replace(*there, words);
}

std::string LivePage::url() const {
  return "http://127.0.0.1:" + std::to_string(impl_->connections.port()) + "/";
}

}  // namespace sheen
