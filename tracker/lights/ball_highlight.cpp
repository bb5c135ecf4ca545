// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/ball_highlight.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/base/angle.h"
#include "common/base/order_statistics.h"
#include "tracker/lights/image_matrix.h"

namespace sheen {
namespace {

constexpr double kDisc = 0.985;          // radii: beyond, pixels are mixed with what is behind the ball
constexpr double kRim = 0.96;            // radii: farther out a direction is a matter of a hundredth of the radius
constexpr float kLeastLight = 0.02f;     // of white, above what stands still
constexpr float kLeastSigmas = 8;        // of the noise
constexpr double kSecond = 0.5;          // of the first one's light: as much is another light
constexpr double kLargest_deg = 15;      // RMS half width of a lamp
constexpr double kFarthest_deg = 3;      // uncertainty
constexpr double kPlaceFloor_px = 0.05;  // standard deviation of any centroid
constexpr double kSaturated = 0.9;       // of white
constexpr double kUneven = 0.05;         // of a highlight's RMS radius: lamps are not equally bright all over

/// Middle and standard deviation of the noise of what lies in the disc.
struct Level {
  float middle = 0, sigma = 0;
};
Level level_of(const ImageF& light, const ImageU8& disc) {
  std::vector<float> values;
  for (std::size_t i = 0; i < light.size(); ++i)
    if (disc.data()[i] != 0) values.push_back(light.data()[i]);
  Level level;
  if (values.empty()) return level;
  level.middle = median(values);
  for (float& value : values) value = std::abs(value - level.middle);
  level.sigma = 1.4826f * median(values);
  return level;
}

}  // namespace

HighlightFinder::HighlightFinder(const BallView& view, const BallOutline& outline, const BallCrop& crop,
                                 ImageF background)
    : view_(view),
      outline_(outline),
      ball_(view, outline.circle),
      crop_(crop),
      background_(std::move(background)),
      disc_(background_.width(), background_.height(), 1),
      beside_hidden_(background_.width(), background_.height(), 1) {
  ImageU8 hidden(disc_.width(), disc_.height(), 1, 255);
  for (int y = 0; y < disc_.height(); ++y)
    for (int x = 0; x < disc_.width(); ++x) {
      const Eigen::Vector2d place = crop_.place({x, y});
      const bool border = x == 0 || y == 0 || x + 1 == disc_.width() || y + 1 == disc_.height();
      if (border || !view.shows(place)) continue;
      hidden.at(x, y) = 0;
      if ((place - outline.circle.centre).norm() < kDisc * outline.circle.radius) disc_.at(x, y) = 255;
    }
  cv::Mat near = wrapped(beside_hidden_);
  cv::dilate(wrapped(hidden), near, cv::Mat::ones(3, 3, CV_8U));
}

HighlightFinder::Answer HighlightFinder::find(const ImageF& picture) const {
  ImageF light = crop_.of(picture);
  for (std::size_t i = 0; i < light.size(); ++i) light.data()[i] -= background_.data()[i];
  const Level level = level_of(light, disc_);
  cv::Mat smooth;
  cv::GaussianBlur(wrapped(light), smooth, {}, 0.7);
  double peak = 0;
  cv::Point top;
  cv::minMaxLoc(smooth, nullptr, &peak, nullptr, &top, wrapped(disc_));
  const float rise = static_cast<float>(peak) - level.middle;
  if (rise < std::max(kLeastLight, kLeastSigmas * level.sigma)) return {{}, "no_highlight"};

  const Eigen::Vector2d top_place = crop_.place({top.x, top.y});
  if ((top_place - outline_.circle.centre).norm() > kRim * outline_.circle.radius) return {{}, "highlight_at_rim"};

  const float least = level.middle + rise / 2;
  const cv::Mat spots = (smooth > least) & wrapped(disc_);
  cv::Mat labels;
  const int count = cv::connectedComponents(spots, labels, 8, CV_32S);
  std::vector<double> energy(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      energy[static_cast<std::size_t>(labels.at<int>(y, x))] += double(light.at(x, y)) - double(level.middle);
  const int main = labels.at<int>(top);
  for (int other = 1; other < count; ++other)
    if (other != main && energy[static_cast<std::size_t>(other)] > kSecond * energy[static_cast<std::size_t>(main)])
      return {{}, "several_highlights"};

  struct Pixel {
    Eigen::Vector2d place;
    Eigen::Vector3d direction;
    double weight;
  };
  std::vector<Pixel> pixels;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double weights = 0;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      if (labels.at<int>(y, x) != main) continue;
      if (beside_hidden_.at(x, y) != 0) return {{}, "highlight_cut_off"};
      const Eigen::Vector2d at = crop_.place({x, y});
      const auto towards = ball_.light_at(at);
      const double weight = static_cast<double>(smooth.at<float>(y, x) - least);
      if (!towards || !(weight > 0)) continue;
      pixels.push_back({at, *towards, weight});
      direction += weight * *towards;
      place += weight * at;
      weights += weight;
    }
  if (pixels.empty()) return {{}, "highlight_at_rim"};
  direction.normalize();
  place /= weights;
  double spread = 0, angles = 0, noise = 0;
  for (const Pixel& pixel : pixels) {
    const double from_middle = (pixel.place - place).squaredNorm();
    spread += pixel.weight * from_middle / weights;
    noise += from_middle / 2 * std::pow(static_cast<double>(level.sigma) / weights, 2);
    angles += pixel.weight * (pixel.direction - direction).squaredNorm() / weights;
  }
  // Of a saturated spot only the pixels are known that it covers: each of those at its edge is off by a part of a
  // pixel.
  const double radius = std::sqrt(static_cast<double>(pixels.size()) / M_PI);
  if (peak + static_cast<double>(background_.at(top.x, top.y)) > kSaturated)
    noise += std::pow(crop_.scale(), 2) / (12 * M_PI * radius);
  if (std::sqrt(angles) / kDegree > kLargest_deg) return {{}, "highlight_too_large"};
  Highlight found{.direction = direction, .place = place};
  found.uncertainty_deg =
      uncertainty_deg(place, noise + std::pow(kPlaceFloor_px * crop_.scale(), 2) + kUneven * kUneven * spread / 2);
  if (!(found.uncertainty_deg < kFarthest_deg)) return {{}, "highlight_at_rim"};
  return {found, {}};
}

/// `place_variance`: of each coordinate. By differences; infinite where the ball ends.
double HighlightFinder::uncertainty_deg(const Eigen::Vector2d& place, double place_variance) const {
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();  // place, centre, radius
  covariance.topLeftCorner<2, 2>().diagonal().setConstant(place_variance);
  covariance.bottomRightCorner<3, 3>() = outline_.covariance;
  const double step = 1e-3 * outline_.circle.radius;
  Eigen::Matrix<double, 3, 5> by;
  for (int k = 0; k < 5; ++k) {
    Eigen::Vector3d sides[2];
    for (const int side : {0, 1}) {
      const double change = side == 0 ? -step : step;
      Eigen::Vector2d at = place;
      BallCircle circle = outline_.circle;
      if (k < 2) at[k] += change;
      if (k == 2 || k == 3) circle.centre[k - 2] += change;
      if (k == 4) circle.radius += change;
      const auto towards = MirrorBall(view_, circle).light_at(at);
      if (!towards) return HUGE_VAL;
      sides[side] = *towards;
    }
    by.col(k) = (sides[1] - sides[0]) / (2 * step);
  }
  return std::sqrt((by * covariance * by.transpose()).trace()) / kDegree;
}

std::string refusal_text(const std::string& refusal) {
  static const std::map<std::string, std::string> texts{
      {"no_highlight",
       "nothing on the ball is brighter than what all images show; the lamp may be hidden, off, or behind"},
      {"several_highlights", "two spots on the ball are about as bright; leave one lamp on, cover windows"},
      {"highlight_too_large",
       "the bright spot mirrors more than 15 degrees of the surroundings: no lamp, or a near wall"},
      {"highlight_cut_off", "the highlight is cut off by the border of the image"},
      {"highlight_at_rim", "the highlight is at the rim of the ball, where its direction is not known to 3 degrees"}};
  return texts.at(refusal);
}

}  // namespace sheen
