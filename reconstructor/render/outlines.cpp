// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/outlines.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace sheen {
namespace {

/// Marks the pixels of one segment: halves it until its ends are a quarter of a pixel apart. What is cut off a pixel
/// unmarked is then at most a corner of 1/64 of its area.
class SegmentMarker {
 public:
  SegmentMarker(const Camera& camera, ImageU8& marks) : camera_(camera), marks_(marks) {}

  void mark(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    mark(a, camera_.project(a), b, camera_.project(b), {});
  }

 private:
  using Pixel = std::optional<Eigen::Vector2d>;
  struct Halvings {
    int all = 0;
    int blind = 0;  ///< of them, those of pieces of which the camera sees neither end
  };
  static constexpr int kMostHalvings = 18, kMostBlind = 5;
  static constexpr double kStep = 0.25;

  void mark(const Eigen::Vector3d& a, const Pixel& at_a, const Eigen::Vector3d& b, const Pixel& at_b, Halvings done) {
    const bool near = at_a && at_b && (*at_a - *at_b).norm() <= kStep;
    if (near || done.all == kMostHalvings) {
      if (at_a) mark(*at_a);
      if (at_b) mark(*at_b);
      return;
    }
    // A lens bends a segment, by less than its length: beside the picture by more than that, all of it is.
    if (at_a && at_b && is_far_outside(*at_a, *at_b)) return;
    if (!at_a && !at_b && ++done.blind > kMostBlind) return;
    ++done.all;
    const Eigen::Vector3d middle = (a + b) / 2;
    const Pixel at_middle = camera_.project(middle);
    mark(a, at_a, middle, at_middle, done);
    mark(middle, at_middle, b, at_b, done);
  }

  bool is_far_outside(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    const double margin = 1 + (a - b).norm();
    const Eigen::Vector2d low = a.cwiseMin(b).array() - margin, high = a.cwiseMax(b).array() + margin;
    return high.x() < 0 || high.y() < 0 || low.x() > camera_.width - 1 || low.y() > camera_.height - 1;
  }

  void mark(const Eigen::Vector2d& pixel) {
    if (camera_.contains(pixel, -0.5 + 1e-9))
      marks_.at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))) = 255;
  }

  const Camera& camera_;
  ImageU8& marks_;
};

}  // namespace

Outlines::Outlines(const Mesh& mesh) : vertices_(mesh.vertices) {
  struct Side {
    std::array<std::uint32_t, 2> vertices;  ///< ascending
    std::uint32_t triangle;
    auto key() const { return std::tie(vertices, triangle); }
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    planes_.push_back({mesh.area_normal(t), mesh.corner(t, 0)});
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]);
      sides.push_back({{low, high}, t});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key() < b.key(); });
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    while (end < sides.size() && sides[end].vertices == sides[i].vertices) ++end;
    edges_.push_back({sides[i].vertices, {sides[i].triangle, sides[end - i == 2 ? i + 1 : i].triangle}});
  }
}

ImageU8 Outlines::pixels(const Camera& camera, const Rigid3& camera_from_object) const {
  ImageU8 marks(camera.width, camera.height, 1);
  SegmentMarker marker(camera, marks);
  const Eigen::Vector3f eye = camera_centre(camera_from_object).cast<float>();
  std::vector<std::uint8_t> faces(planes_.size());
  for (std::size_t t = 0; t < planes_.size(); ++t) faces[t] = planes_[t].normal.dot(eye - planes_[t].point) > 0;
  for (const Edge& edge : edges_) {
    if (edge.triangles[0] != edge.triangles[1] && faces[edge.triangles[0]] == faces[edge.triangles[1]]) continue;
    marker.mark(camera_from_object * vertices_[edge.vertices[0]].cast<double>(),
                camera_from_object * vertices_[edge.vertices[1]].cast<double>());
  }
  return marks;
}

}  // namespace sheen
