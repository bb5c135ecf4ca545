// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/circle_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracker/lights/image_matrix.h"

namespace sheen {
namespace {

constexpr int kLongerSide = 256, kLeastRadius = 6;  // of the small copies, pixels
constexpr double kMostRadius = 0.6;                 // of the longer side
constexpr double kBright = 0.995;                   // the quantile of a picture that counts as 1
constexpr float kEdge = 4;                          // of the median strength: what is an edge
constexpr double kMostEdges = 0.15;                 // of all pixels
constexpr float kLeastVotes = 0.2f;                 // of the outline's length
constexpr std::size_t kKeptPerRadius = 8;

struct Edge {
  cv::Point2f at, normal;
};

/// Where the strength of the tensors' main direction is highest across it.
std::vector<Edge> edges_of(const cv::Mat& xx, const cv::Mat& xy, const cv::Mat& yy) {
  cv::Mat strength(xx.size(), CV_32F);
  for (int y = 0; y < xx.rows; ++y)
    for (int x = 0; x < xx.cols; ++x)
      strength.at<float>(y, x) = std::hypot(xx.at<float>(y, x) - yy.at<float>(y, x), 2 * xy.at<float>(y, x));
  const float least = std::max({kEdge * quantile(strength, 0.5), quantile(strength, 1 - kMostEdges), 1e-12f});
  std::vector<Edge> edges;
  for (int y = 1; y + 1 < xx.rows; ++y)
    for (int x = 1; x + 1 < xx.cols; ++x) {
      const float s = strength.at<float>(y, x);
      if (s < least) continue;
      const float angle = 0.5f * std::atan2(2 * xy.at<float>(y, x), xx.at<float>(y, x) - yy.at<float>(y, x));
      const cv::Point2f normal(std::cos(angle), std::sin(angle));
      const int dx = static_cast<int>(std::lround(normal.x)), dy = static_cast<int>(std::lround(normal.y));
      if (s < strength.at<float>(y + dy, x + dx) || s <= strength.at<float>(y - dy, x - dx)) continue;
      edges.push_back({cv::Point2f(static_cast<float>(x), static_cast<float>(y)), normal});
    }
  return edges;
}

/// Pixels of a circle's outline that lie in the picture.
float visible_length(cv::Point2f centre, float radius, cv::Size picture) {
  constexpr int kSteps = 48;
  int inside = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float angle = static_cast<float>(2 * M_PI * i / kSteps);
    const float x = centre.x + radius * std::cos(angle), y = centre.y + radius * std::sin(angle);
    inside +=
        x >= 1 && y >= 1 && x <= static_cast<float>(picture.width - 2) && y <= static_cast<float>(picture.height - 2);
  }
  return static_cast<float>(2 * M_PI / kSteps) * radius * static_cast<float>(inside);
}

struct Vote {
  cv::Point2f centre;
  float radius;
  float weight;  ///< how unlikely by chance: of small circles many fit to any clutter
};
bool alike(const Vote& a, const Vote& b) {
  const float larger = std::max(a.radius, b.radius);
  return std::hypot(a.centre.x - b.centre.x, a.centre.y - b.centre.y) < 0.25f * larger + 2 &&
         std::abs(a.radius - b.radius) < 0.2f * larger + 1;
}

/// The best centres of circles of one radius.
void vote(const std::vector<Edge>& edges, float radius, cv::Size picture, std::vector<Vote>& votes) {
  const int margin = static_cast<int>(0.6f * radius) + 2;  // a centre may lie outside of the picture
  cv::Mat counts = cv::Mat::zeros(picture.height + 2 * margin, picture.width + 2 * margin, CV_32F);
  for (const Edge& edge : edges)
    for (const float side : {radius, -radius}) {
      const int x = static_cast<int>(std::lround(edge.at.x + side * edge.normal.x)) + margin;
      const int y = static_cast<int>(std::lround(edge.at.y + side * edge.normal.y)) + margin;
      if (x >= 0 && y >= 0 && x < counts.cols && y < counts.rows) counts.at<float>(y, x) += 1;
    }
  const int window = 3 + 2 * static_cast<int>(radius / 25);  // normals are uncertain
  cv::Mat sums, highest;
  cv::boxFilter(counts, sums, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  sums -= cv::mean(sums)[0];  // of clutter
  cv::dilate(sums, highest, cv::Mat::ones(5, 5, CV_8U));
  std::vector<Vote> found;
  for (int y = 0; y < sums.rows; ++y)
    for (int x = 0; x < sums.cols; ++x) {
      const float sum = sums.at<float>(y, x);
      if (sum < highest.at<float>(y, x) || sum < kLeastVotes * radius) continue;
      const cv::Point2f centre(static_cast<float>(x - margin), static_cast<float>(y - margin));
      const float length = visible_length(centre, radius, picture);
      // An arc of less than a quarter of the circle says little.
      if (length > static_cast<float>(M_PI / 2) * radius && sum > kLeastVotes * length)
        found.push_back({centre, radius, sum / std::sqrt(length)});
    }
  const std::size_t kept = std::min(found.size(), kKeptPerRadius);
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(),
                    [](const Vote& a, const Vote& b) { return a.weight > b.weight; });
  votes.insert(votes.end(), found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept));
}

}  // namespace

void CircleSearch::add(const ImageF& light) {
  scale_ = std::min(1.0, double(kLongerSide) / std::max(light.width(), light.height()));
  const cv::Size size(std::max(1, static_cast<int>(std::lround(scale_ * light.width()))),
                      std::max(1, static_cast<int>(std::lround(scale_ * light.height()))));
  cv::Mat small, dx, dy;
  cv::resize(wrapped(light), small, size, 0, 0, cv::INTER_AREA);
  small /= std::max(quantile(small, kBright), 1e-4f);
  cv::sqrt(cv::min(cv::max(small, 0.0), 1.0), small);  // dark outlines count, too
  cv::GaussianBlur(small, small, {}, 0.8);
  cv::Scharr(small, dx, CV_32F, 1, 0, 1 / 32.0);
  cv::Scharr(small, dy, CV_32F, 0, 1, 1 / 32.0);
  if (xx_.empty()) xx_ = xy_ = yy_ = ImageF(size.width, size.height, 1);
  cv::Mat xx = wrapped(xx_), xy = wrapped(xy_), yy = wrapped(yy_);
  cv::accumulateProduct(dx, dx, xx);
  cv::accumulateProduct(dx, dy, xy);
  cv::accumulateProduct(dy, dy, yy);
}

std::vector<BallCircle> CircleSearch::circles(std::size_t most) const {
  if (std::min(xx_.width(), xx_.height()) < 2 * kLeastRadius) return {};
  cv::Mat xx, xy, yy;
  cv::GaussianBlur(wrapped(xx_), xx, {}, 0.8);
  cv::GaussianBlur(wrapped(xy_), xy, {}, 0.8);
  cv::GaussianBlur(wrapped(yy_), yy, {}, 0.8);
  const std::vector<Edge> edges = edges_of(xx, xy, yy);
  std::vector<Vote> votes;
  for (int radius = kLeastRadius; radius <= kMostRadius * std::max(xx.cols, xx.rows); ++radius)
    vote(edges, static_cast<float>(radius), xx.size(), votes);
  std::sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) { return a.weight > b.weight; });
  std::vector<Vote> kept;
  for (const Vote& vote : votes) {
    if (kept.size() == most) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const Vote& other) { return alike(vote, other); }))
      kept.push_back(vote);
  }
  std::vector<BallCircle> circles;
  for (const Vote& vote : kept)
    circles.push_back(
        {(Eigen::Vector2d(vote.centre.x, vote.centre.y).array() + 0.5) / scale_ - 0.5, vote.radius / scale_});
  return circles;
}

}  // namespace sheen
