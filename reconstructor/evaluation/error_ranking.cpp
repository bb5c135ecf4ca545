// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/error_ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/image/color.h"

namespace sheen {
namespace {

constexpr int kFewestPixels = 4;

/// Ranks minus their mean; equal values share theirs.
std::vector<double> centred_ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  std::vector<double> ranks(values.size());
  const double mean = (static_cast<double>(values.size()) - 1) / 2;
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (std::size_t i = first; i < last; ++i) ranks[order[i]] = static_cast<double>(first + last - 1) / 2 - mean;
  }
  return ranks;
}

/// Squared error of encoded values, summed over channels and pixels.
struct TriangleError {
  double sum = 0;
  int pixels = 0;
  double rms() const { return std::sqrt(sum / (3.0 * pixels)); }
};

}  // namespace

double rank_correlation(std::span<const double> a, std::span<const double> b) {
  const std::vector<double> x = centred_ranks(a), y = centred_ranks(b);
  const double xx = std::inner_product(x.begin(), x.end(), x.begin(), 0.0);
  const double yy = std::inner_product(y.begin(), y.end(), y.begin(), 0.0);
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0) / std::sqrt(xx * yy);
}

ErrorRanking judge_error_ranking(const std::vector<HeldOutView>& views, const Appearance& model,
                                 const BaselineHeuristic& other, const RayPainter& painter) {
  std::vector<double> predicted, by_peer, measured;
  ErrorRanking result;
  for (const HeldOutView& view : views) {
    const JudgedPixels pixels = view.pixels();
    const std::vector<Hit> hits = painter.cast(view.camera, view.camera_from_object);
    const PaintedView painted = painter.paint(model, view.camera, view.camera_from_object, view.light);
    const ImageU8 picture = to_srgb8(painted.beauty);
    const std::vector<float> heuristic = other.of(camera_centre(view.camera_from_object));
    std::vector<TriangleError> errors(model.mesh().triangles.size());
    std::vector<double> expected(errors.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!pixels.inside.data()[i] || !hits[i]) continue;
      TriangleError& triangle = errors[hits[i].triangle];
      ++triangle.pixels;
      expected[hits[i].triangle] = painted.predicted_error.data()[i];
      for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
        const double difference = (double(picture.data()[c]) - double(pixels.truth.data()[c])) / 255;
        triangle.sum += difference * difference;
      }
    }
    for (std::size_t t = 0; t < errors.size(); ++t) {
      if (errors[t].pixels < kFewestPixels) continue;
      predicted.push_back(expected[t]);
      by_peer.push_back(heuristic[t]);
      measured.push_back(errors[t].rms());
    }
  }
  result.rank_correlation = rank_correlation(predicted, measured);
  result.other_rank_correlation = rank_correlation(by_peer, measured);
  return result;
}

}  // namespace sheen
