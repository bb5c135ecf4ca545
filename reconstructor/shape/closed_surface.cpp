// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/closed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>

#include "reconstructor/shape/sign_blocks.h"

namespace sheen {
namespace {

constexpr int kSide = SignBlocks::kSide, kWide = kSide + 1;

/// From a corner of a cube, 0 to 7 (bit 0: upper in x, bit 1: in y, bit 2: in z).
Eigen::Array3i step(int corner) {
  return {corner & 1, corner >> 1 & 1, corner >> 2};
}

/// An edge of the tetrahedra in a cube. The corner where it begins has no bit that the one where it ends has not.
struct CubeEdge {
  std::uint8_t from;   ///< corner
  std::uint8_t along;  ///< 1 to 7, to corner from + along
};
using CubeTriangle = std::array<CubeEdge, 3>;

CubeEdge edge_between(int a, int b) {
  const int from = std::min(a, b),
            to = std::max(a, b);  // of two corners of a tetrahedron the lower one holds no more bits
  return {static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(to - from)};
}

/// Turned so that it is seen counter-clockwise from the outside corners.
CubeTriangle facing(CubeTriangle triangle, int inside, int outside) {
  const auto middle = [](const CubeEdge& edge) -> Eigen::Vector3d {
    return (step(edge.from) + step(edge.from + edge.along)).cast<double>() / 2;
  };
  const Eigen::Vector3d a = middle(triangle[0]), b = middle(triangle[1]), c = middle(triangle[2]);
  const Eigen::Vector3d outwards = (step(outside) - step(inside)).cast<double>();
  if ((b - a).cross(c - a).dot(outwards) < 0) std::swap(triangle[1], triangle[2]);
  return triangle;
}

void add_tetrahedron(const std::array<int, 4>& corners, unsigned inside, std::vector<CubeTriangle>& triangles) {
  std::vector<int> in, out;
  for (const int corner : corners) (inside >> corner & 1 ? in : out).push_back(corner);
  if (in.size() == 1 || out.size() == 1) {
    const int alone = in.size() == 1 ? in[0] : out[0];
    const std::vector<int>& others = in.size() == 1 ? out : in;
    CubeTriangle triangle;
    for (int i = 0; i < 3; ++i) triangle[i] = edge_between(alone, others[i]);
    triangles.push_back(facing(triangle, in[0], out[0]));
  } else if (in.size() == 2) {
    const CubeEdge a = edge_between(in[0], out[0]), b = edge_between(in[0], out[1]), c = edge_between(in[1], out[1]),
                   d = edge_between(in[1], out[0]);
    triangles.push_back(facing({a, b, c}, in[0], out[0]));
    triangles.push_back(facing({a, c, d}, in[0], out[0]));
  }
}

/// Per set of inside corners the triangles of a cube.
std::array<std::vector<CubeTriangle>, 256> cube_cases() {
  std::array<std::vector<CubeTriangle>, 256> cases;
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::array<int, 3> axes{0, 1, 2};
    do {
      const int first = 1 << axes[0], second = first | 1 << axes[1];
      add_tetrahedron({0, first, second, 7}, inside, cases[inside]);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  return cases;
}

/// The vertices on the edges that begin in a block.
struct BlockVertices {
  std::uint32_t first = 0;
  std::array<std::uint16_t, BlockField::kBlockPoints> before{};  ///< per point the vertices of points before it
  std::array<std::uint8_t, BlockField::kBlockPoints>
      crossed{};  ///< per point, bit a - 1: its edge along a has a vertex

  std::uint32_t vertex(int point, int along) const {
    return first + before[point] + std::popcount(crossed[point] & ((1u << (along - 1)) - 1u));
  }
};

class Marching {
 public:
  Marching(const BlockField& field, const SignBlocks& signs)
      : field_(field), signs_(signs), number_(signs.numbers(), kNone) {
    signs.for_each_block([&](std::size_t number) { add_vertices(number); });
  }

  Mesh mesh() const {
    std::vector<Triangle> triangles;
    triangles.reserve(2 * vertices_.size());
    signs_.for_each_block([&](std::size_t number) { add_triangles(number, triangles); });
    return mesh_of(vertices_, std::move(triangles));
  }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  /// Bit x of the edges along `a` from the points of a row.
  static unsigned crossings(const SignBlocks::WideRows& rows, int y, int z, int along) {
    const int dx = along & 1, dy = along >> 1 & 1, dz = along >> 2;
    return (rows[y + kWide * z] ^ rows[y + dy + kWide * (z + dz)] >> dx) & 0xff;
  }

  void add_vertices(std::size_t number) {
    if (signs_.of_one_sign(number)) return;
    const SignBlocks::WideRows rows = signs_.wide_rows(number);
    BlockVertices block{.first = static_cast<std::uint32_t>(vertices_.size())};
    const Eigen::Array3i corner = kSide * signs_.block_of(number);
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y) {
        std::array<unsigned, 8> crossed{};
        for (int along = 1; along < 8; ++along) crossed[along] = crossings(rows, y, z, along);
        for (int x = 0; x < kSide; ++x) {
          const int point = BlockField::number_in_block({x, y, z});
          block.before[point] = static_cast<std::uint16_t>(vertices_.size() - block.first);
          for (int along = 1; along < 8; ++along) {
            if (!(crossed[along] >> x & 1)) continue;
            block.crossed[point] |= static_cast<std::uint8_t>(1 << (along - 1));
            vertices_.push_back(vertex(corner + Eigen::Array3i(x, y, z), along));
          }
        }
      }
    if (vertices_.size() == block.first) return;
    number_[number] = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back(block);
  }

  /// Where the field is zero between two points of different signs.
  Eigen::Vector3d vertex(const Eigen::Array3i& from, int along) const {
    // Without signs: a point of the border is outside whatever its value is.
    const double here = std::abs(double(field_.at(from))), there = std::abs(double(field_.at(from + step(along))));
    const double share = here / (here + there);  // NaN: both are zero or endless
    const double kept = share >= 0 ? std::clamp(share, kVertexMargin, 1 - kVertexMargin) : 0.5;
    return field_.lattice().at(from) + kept * field_.lattice().cell * step(along).cast<double>().matrix();
  }

  void add_triangles(std::size_t number, std::vector<Triangle>& triangles) const {
    static const std::array<std::vector<CubeTriangle>, 256> kCases = cube_cases();
    if (number_[number] == kNone) return;
    const SignBlocks::WideRows rows = signs_.wide_rows(number);
    const BlockVertices& block = blocks_[number_[number]];
    for (int point = 0; point < BlockField::kBlockPoints; ++point) {
      if (block.crossed[point] == 0) continue;
      const int x = point % kSide, y = point / kSide % kSide, z = point / (kSide * kSide);
      // What the edges from the lowest corner do not cross to has its sign.
      const unsigned lowest = rows[y + kWide * z] >> x & 1;
      const unsigned inside = (unsigned(block.crossed[point]) << 1 ^ (lowest ? 0xffu : 0u)) & 0xff;
      for (const CubeTriangle& triangle : kCases[inside]) {
        Triangle& added = triangles.emplace_back();
        for (int c = 0; c < 3; ++c) added[c] = vertex_of(number, x, y, z, triangle[c]);
      }
    }
  }

  /// Of an edge of the cube whose lowest corner is (x, y, z) in a block.
  std::uint32_t vertex_of(std::size_t number, int x, int y, int z, const CubeEdge& edge) const {
    x += edge.from & 1, y += edge.from >> 1 & 1, z += edge.from >> 2;
    const BlockVertices& block = blocks_[number_[signs_.holder(number, x, y, z)]];
    return block.vertex(BlockField::number_in_block({x % kSide, y % kSide, z % kSide}), edge.along);
  }

  const BlockField& field_;
  const SignBlocks& signs_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::uint32_t> number_;  ///< per block of the signs, its place in blocks_
  std::vector<BlockVertices> blocks_;
};

}  // namespace

ClosedSurface closed_surface(const BlockField& field) {
  SignBlocks signs(field);
  ClosedSurface surface{.forced_outside = signs.forced_outside()};
  surface.counts = make_one_piece(signs);
  surface.mesh = Marching(field, signs).mesh();
  return surface;
}

}  // namespace sheen
