// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/depth_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "reconstructor/shape/window_matcher.h"

namespace sheen {
namespace {

constexpr int kSweeps = 2;
constexpr int kFirstGuesses = 3;
constexpr float kFlattest = 0.15f;  // cosine of the ray with the normal
constexpr float kTilt = 0.4f;       // by which a normal is varied
constexpr float kVariedPixels = 2;  // by which a place is varied, pixels in another view
constexpr float kMostCost = 0.6f;

/// Numbers by chance, the same on every machine (xorshift64*).
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 0x2545f4914f6cdd1du) {}
  /// From -1 to 1.
  float either_way() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return static_cast<float>(static_cast<std::int32_t>((state_ * 0x2545f4914f6cdd1du) >> 32)) * 0x1p-31f;
  }
  Eigen::Vector3f vector() {
    const float x = either_way(), y = either_way(), z = either_way();
    return {x, y, z};
  }

 private:
  std::uint64_t state_;
};

class DepthSearch {
 public:
  DepthSearch(WindowMatcher matcher, const DepthRange& range, DepthMap map, std::uint64_t seed)
      : matcher_(std::move(matcher)), range_(range), map_(std::move(map)), chance_(seed) {}

  void guess() {
    for_each_pixel(true, [&](int x, int y) {
      for (int i = 0; i < kFirstGuesses; ++i) try_piece(x, y, anything(x, y));
    });
  }
  /// What was found is judged again.
  void judge() {
    for_each_pixel(true, [&](int x, int y) {
      if (map_.depth.at(x, y) > 0) map_.cost.at(x, y) = matcher_.cost(piece_at(x, y));
    });
  }
  void sweep(bool forward, bool widely) {
    const int before = forward ? -1 : 1;
    for_each_pixel(forward, [&](int x, int y) {
      try_from(x, y, x + before, y);
      try_from(x, y, x, y + before);
      if (widely) try_piece(x, y, anything(x, y));
      const float varied = kVariedPixels * matcher_.depth_per_pixel(map_.depth.at(x, y));
      for (const auto& [place, tilt] :
           {std::pair{varied, 0.0f}, std::pair{0.0f, kTilt}, std::pair{0.25f * varied, 0.25f * kTilt}}) {
        SurfacePiece piece = piece_at(x, y);
        piece.depth += place * chance_.either_way();
        if (tilt > 0) piece.normal = (piece.normal + tilt * chance_.vector()).normalized();
        try_piece(x, y, piece);
      }
    });
  }
  DepthMap take() { return std::move(map_); }

 private:
  /// Of the pixels in the range whose window can be used.
  template <typename Work>
  void for_each_pixel(bool forward, const Work& work) {
    const int width = map_.depth.width(), height = map_.depth.height();
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i) {
        const int x = forward ? i : width - 1 - i, y = forward ? j : height - 1 - j;
        if (range_.farthest.at(x, y) > 0 && matcher_.take(x, y)) work(x, y);
      }
  }

  SurfacePiece piece_at(int x, int y) const {
    return {map_.depth.at(x, y), Eigen::Map<const Eigen::Vector3f>(map_.normal.pixel(x, y))};
  }

  SurfacePiece anything(int x, int y) {
    const float nearest = range_.nearest.at(x, y), farthest = range_.farthest.at(x, y);
    const float t = 0.5f + 0.5f * chance_.either_way();
    const Eigen::Vector3f towards = -ray(x, y).normalized();
    return {1 / ((1 - t) / nearest + t / farthest), (towards + 0.8f * chance_.vector()).normalized()};
  }

  void try_from(int x, int y, int from_x, int from_y) {
    if (from_x < 0 || from_y < 0 || from_x >= map_.depth.width() || from_y >= map_.depth.height()) return;
    SurfacePiece piece = piece_at(from_x, from_y);
    if (!(piece.depth > 0)) return;
    piece.depth *= piece.normal.dot(ray(from_x, from_y)) / piece.normal.dot(ray(x, y));
    try_piece(x, y, piece);
  }

  void try_piece(int x, int y, const SurfacePiece& piece) {
    if (!(piece.depth >= range_.nearest.at(x, y) && piece.depth <= range_.farthest.at(x, y))) return;
    const Eigen::Vector3f r = ray(x, y);
    if (!(-piece.normal.dot(r) > kFlattest * r.norm())) return;
    const float best = map_.depth.at(x, y) > 0 ? map_.cost.at(x, y) : std::numeric_limits<float>::infinity();
    const float cost = matcher_.cost(piece, best);
    if (cost >= best) return;
    map_.depth.at(x, y) = piece.depth;
    Eigen::Map<Eigen::Vector3f>(map_.normal.pixel(x, y)) = piece.normal;
    map_.cost.at(x, y) = cost;
  }

  Eigen::Vector3f ray(int x, int y) const { return matcher_.ray(static_cast<float>(x), static_cast<float>(y)); }

  WindowMatcher matcher_;
  const DepthRange& range_;
  DepthMap map_;
  Chance chance_;
};

}  // namespace

DepthMap search_depth(const ShapeView& view, const std::vector<const ShapeView*>& neighbours, const DepthRange& range,
                      std::uint64_t seed) {
  const int width = view.grey.width(), height = view.grey.height();
  DepthMap nothing{ImageF(width, height, 1), ImageF(width, height, 3), ImageF(width, height, 1)};
  DepthSearch search(WindowMatcher(view, neighbours), range, std::move(nothing), seed);
  search.guess();
  for (int i = 0; i < kSweeps; ++i) search.sweep(i % 2 == 0, true);
  return search.take();
}

DepthMap search_depth_again(const ShapeView& view, const std::vector<const ShapeView*>& neighbours,
                            const std::vector<const ImageF*>& depths, const DepthRange& range, DepthMap found,
                            std::uint64_t seed) {
  DepthSearch search(WindowMatcher(view, neighbours, depths), range, std::move(found), seed);
  search.judge();
  for (int i = 0; i < kSweeps; ++i) search.sweep(i % 2 == 0, false);
  return search.take();
}

ImageU8 agreeing_neighbours(const ShapeView& view, const DepthMap& found,
                            const std::vector<const ShapeView*>& neighbours, const std::vector<const ImageF*>& depths) {
  constexpr float kMostPixels = 1, kMostDepth = 0.005f;
  ImageU8 agreeing(found.depth.width(), found.depth.height(), 1);
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const WindowMatcher one(view, {neighbours[n]}, {depths[n]});
    for (int y = 0; y < agreeing.height(); ++y)
      for (int x = 0; x < agreeing.width(); ++x) {
        const float depth = found.depth.at(x, y);
        if (!(depth > 0) || found.cost.at(x, y) > kMostCost) continue;
        const std::optional<WayBack> back = one.way_back(0, x, y, depth);
        if (back && back->pixels < kMostPixels && back->depth_off < kMostDepth) ++agreeing.at(x, y);
      }
  }
  return agreeing;
}

}  // namespace sheen
