// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/ball_outline.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tracker/fiducials/grey_sample.h"
#include "tracker/lights/image_matrix.h"

namespace sheen {
namespace {

constexpr double kCropReach = 1.45, kCropRadius = 200;  // radii; pixels of a crop that a radius may have
constexpr double kBright = 0.995;                       // quantile of a crop beyond which light is cut: highlights
constexpr float kDark = 0.02f;                          // light of a crop that is too dark to tell much
constexpr double kStep = 0.25;                          // pixels of a crop
constexpr float kEdge = 5;                              // of the quiet part of the crop
constexpr double kLeastSupport = 0.5, kLeastVisible = 0.3, kUncertain = 1.0 / 30;

}  // namespace

BallCrop::BallCrop(ImageSize picture, const BallCircle& ball)
    : factor_(std::max(1, static_cast<int>(ball.radius / kCropRadius))) {
  const auto edge = [](double at, int most) { return static_cast<int>(std::clamp(at, 0.0, double(most))); };
  const double reach = kCropReach * ball.radius;
  box_ = {edge(ball.centre.x() - reach, picture.width), edge(ball.centre.y() - reach, picture.height),
          edge(ball.centre.x() + reach + 2, picture.width), edge(ball.centre.y() + reach + 2, picture.height)};
  box_.x1 -= box_.width() % factor_;
  box_.y1 -= box_.height() % factor_;
}

ImageF BallCrop::of(const ImageF& picture) const {
  ImageF crop(box_.width() / factor_, box_.height() / factor_, 1);
  cv::Mat out = wrapped(crop);
  cv::resize(wrapped(picture)(cv::Rect(box_.x0, box_.y0, box_.width(), box_.height())), out, out.size(), 0, 0,
             cv::INTER_AREA);
  return crop;
}

Eigen::Vector2d BallCrop::place(const Eigen::Vector2d& pixel) const {
  return Eigen::Vector2d(box_.x0, box_.y0) + (((pixel.array() + 0.5) * factor_) - 0.5).matrix();
}
Eigen::Vector2d BallCrop::pixel(const Eigen::Vector2d& place) const {
  return (((place - Eigen::Vector2d(box_.x0, box_.y0)).array() + 0.5) / factor_ - 0.5).matrix();
}

BallEvidence::BallEvidence(const BallView& view, const BallCircle& about)
    : view_(view), about_(about), crop_(view.size(), about) {}

void BallEvidence::add(const ImageF& picture) {
  const ImageF crop = crop_.of(picture);
  if (pictures_++ == 0) {
    xx_ = xy_ = yy_ = sum_ = ImageF(crop.width(), crop.height(), 1);
    brightest_ = crop;
  }
  cv::Mat sum = wrapped(sum_), brightest = wrapped(brightest_), light;
  sum += wrapped(crop);
  cv::max(brightest, wrapped(crop), brightest);
  const float bright = quantile(wrapped(crop), kBright);
  cv::min(wrapped(crop), bright, light);
  light /= bright + kDark;
  cv::GaussianBlur(light, light, {}, 1);
  cv::Mat dx, dy, xx = wrapped(xx_), xy = wrapped(xy_), yy = wrapped(yy_);
  cv::Scharr(light, dx, CV_32F, 1, 0, 1 / 32.0);
  cv::Scharr(light, dy, CV_32F, 0, 1, 1 / 32.0);
  cv::accumulateProduct(dx, dx, xx);
  cv::accumulateProduct(dx, dy, xy);
  cv::accumulateProduct(dy, dy, yy);
}

ImageF BallEvidence::background() const {
  ImageF still(sum_.width(), sum_.height(), 1);
  if (pictures_ > 1)
    for (std::size_t i = 0; i < still.size(); ++i)
      still.data()[i] = (sum_.data()[i] - brightest_.data()[i]) / static_cast<float>(pictures_ - 1);
  return still;
}

std::vector<RimPoint> BallEvidence::rim_points(const BallCircle& about, std::size_t rays, const Shown& shown) const {
  const float least = std::max(kEdge * quantile(wrapped(xx_) + wrapped(yy_), 0.25), 1e-9f);
  std::vector<RimPoint> edges;
  for (std::size_t ray = 0; ray < rays; ++ray) {
    const double angle = 2 * M_PI * static_cast<double>(ray) / static_cast<double>(rays);
    const Eigen::Vector2d n(std::cos(angle), std::sin(angle)), t(-n.y(), n.x());
    const double first = (1 - 1.4 * kRimSearch) * about.radius, last = (1 + 1.4 * kRimSearch) * about.radius;
    float before = 0, middle = 0;
    for (double along = first; along <= last; along += kStep) {
      const Eigen::Vector2d at = about.centre + along * n;
      if (!shown(at)) {
        before = middle = 0;
        continue;
      }
      const double xx = bilinear(xx_, at), xy = bilinear(xy_, at), yy = bilinear(yy_, at);
      const auto energy = [&](const Eigen::Vector2d& d) {
        return d.x() * d.x() * xx + 2 * d.x() * d.y() * xy + d.y() * d.y() * yy;
      };
      const auto here = static_cast<float>(energy(n) - energy(t));
      if (middle > least && middle > before && middle >= here) {
        const double bend = double(before) - 2 * double(middle) + double(here);
        const double shift = bend < 0 ? 0.5 * (double(before) - double(here)) / bend : 0;
        edges.push_back({ray, about.centre + (along + kStep * (shift - 1)) * n});
      }
      before = middle;
      middle = here;
    }
  }
  return edges;
}

std::optional<BallOutline> BallEvidence::outline() const {
  const BallCircle about{crop_.pixel(about_.centre), about_.radius / crop_.scale()};
  const auto rays = static_cast<std::size_t>(std::clamp(M_PI * about.radius, 48.0, 720.0));
  const auto shown = [&](const Eigen::Vector2d& at) {
    const Eigen::Vector2d place = crop_.place(at);
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(2 * crop_.scale());
    return at.x() >= 1 && at.y() >= 1 && at.x() < xx_.width() - 2 && at.y() < xx_.height() - 2 && view_.shows(place) &&
           view_.shows(place - margin) && view_.shows(place + margin);
  };
  const std::vector<RimPoint> edges = rim_points(about, rays, shown);
  const auto fit = fit_rim(edges, rays, about, shown);
  if (!fit) return std::nullopt;
  BallOutline found;
  const double scale = crop_.scale();
  found.circle = {crop_.place(fit->circle.centre), scale * fit->circle.radius};
  found.covariance = scale * scale * fit->covariance;
  found.visible = fit->visible;
  found.support = fit->support;
  if (found.visible < kLeastVisible || found.support < kLeastSupport ||
      std::sqrt(found.covariance.trace()) > kUncertain * found.circle.radius)
    return std::nullopt;
  return found;
}

}  // namespace sheen
