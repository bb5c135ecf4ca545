// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/mesh_coding.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"

namespace sheen {
namespace {

using Point = GridMesh::Point;

struct Header {
  std::uint32_t vertices = 0, triangles = 0, index_bytes = 0;
  float origin[3] = {}, step = 1;
};

constexpr std::size_t kBefore = 32;  ///< triangles that are looked through for a neighbour
constexpr std::int32_t kFurthest = 1 << 22;
constexpr int kSizes = 24;
constexpr int kContexts = 2 * kSizes * kSignedContexts;

bool has(const Triangle& triangle, std::uint32_t v) {
  return triangle[0] == v || triangle[1] == v || triangle[2] == v;
}

/// The points of a mesh, in the order in which its triangles name them.
class PointCoder {
 public:
  PointCoder(const std::vector<Triangle>& triangles, std::vector<Point>& points)
      : triangles_(triangles), points_(points), known_(points.size(), false) {}

  template <typename Coder>
  void code(Coder& coder) {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (const std::uint32_t v : triangles_[t])
        if (!known_[v]) code_point(coder, t, v);
  }

 private:
  struct Expected {
    Point point{};
    bool parallelogram = false;
  };

  /// A difference from what is expected is about as large as those of late.
  template <typename Coder>
  void code_point(Coder& coder, std::size_t t, std::uint32_t v) {
    const Expected expected = expect(t);
    std::int32_t& size = size_[expected.parallelogram];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int sizes = std::min<int>(std::bit_width(static_cast<std::uint32_t>(size)), kSizes - 1);
      const std::int32_t off = code_signed(coder, (expected.parallelogram * kSizes + sizes) * kSignedContexts,
                                           points_[v][axis] - expected.point[axis]);
      points_[v][axis] = std::clamp(expected.point[axis] + off, -kFurthest, kFurthest);
      size += std::min(std::abs(off), kFurthest) - size / 8;
    }
    known_[v] = true;
    last_ = points_[v];
  }

  /// By the corners of triangle t that are known.
  Expected expect(std::size_t t) const {
    std::array<std::uint32_t, 3> corners;
    std::size_t count = 0;
    for (const std::uint32_t v : triangles_[t])
      if (known_[v]) corners[count++] = v;
    if (count == 0) return {last_};
    if (count == 1) return {points_[corners[0]]};
    const std::optional<std::uint32_t> opposite = across(t, corners[0], corners[1]);
    Point point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t sum = points_[corners[0]][axis] + points_[corners[1]][axis];
      point[axis] = opposite ? sum - points_[*opposite][axis] : sum / 2;
    }
    return {point, opposite.has_value()};
  }

  /// The corner across the edge a, b in one of the triangles before t.
  std::optional<std::uint32_t> across(std::size_t t, std::uint32_t a, std::uint32_t b) const {
    for (std::size_t before = t; before > 0 && before + kBefore > t; --before) {
      const Triangle& triangle = triangles_[before - 1];
      if (!has(triangle, a) || !has(triangle, b)) continue;
      for (const std::uint32_t v : triangle)
        if (v != a && v != b) return v;
    }
    return std::nullopt;
  }

  const std::vector<Triangle>& triangles_;
  std::vector<Point>& points_;
  std::vector<bool> known_;
  Point last_{};
  std::int32_t size_[2] = {};  ///< of differences of late, eight times
};

std::vector<Triangle> decode_triangles(std::string_view bytes, std::size_t count, std::size_t vertices) {
  static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
  std::vector<Triangle> triangles(count);
  if (count == 0 || meshopt_decodeIndexBuffer(triangles.data(), 3 * count, sizeof(std::uint32_t),
                                              reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()) != 0)
    throw std::runtime_error("the mesh is damaged");
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t v : triangle)
      if (v >= vertices) throw std::runtime_error("a triangle has a corner that is not a vertex");
  return triangles;
}

}  // namespace

Mesh GridMesh::mesh() const {
  Mesh mesh;
  mesh.triangles = triangles;
  mesh.vertices.reserve(points.size());
  for (const Point& point : points)
    mesh.vertices.push_back(origin + step * Eigen::Map<const Eigen::Vector3i>(point.data()).cast<float>());
  return mesh;
}

std::string encode_mesh(const GridMesh& mesh) {
  const std::size_t indices = 3 * mesh.triangles.size();
  std::vector<unsigned char> index_bytes(meshopt_encodeIndexBufferBound(indices, mesh.points.size()));
  index_bytes.resize(
      meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(), mesh.triangles.front().data(), indices));
  const std::string coded(index_bytes.begin(), index_bytes.end());
  Header header{.vertices = static_cast<std::uint32_t>(mesh.points.size()),
                .triangles = static_cast<std::uint32_t>(mesh.triangles.size()),
                .index_bytes = static_cast<std::uint32_t>(coded.size()),
                .step = mesh.step};
  Eigen::Map<Eigen::Vector3f>{header.origin} = mesh.origin;
  const std::vector<Triangle> triangles =
      decode_triangles(coded, mesh.triangles.size(), mesh.points.size());  // as a reader has them
  std::vector<Point> points = mesh.points;
  BitModel bits(kContexts);
  ContextEncoder coder(bits);
  PointCoder(triangles, points).code(coder);
  return std::string(reinterpret_cast<const char*>(&header), sizeof header) + coded + coder.finish();
}

GridMesh decode_mesh(std::string_view bytes) {
  Header header;
  if (bytes.size() < sizeof header) throw std::runtime_error("the mesh is cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  // A triangle takes a byte at least; vertices that no triangle has are not stored.
  if (header.index_bytes > bytes.size() || header.triangles > header.index_bytes ||
      header.vertices > 3 * std::uint64_t{header.triangles})
    throw std::runtime_error("the mesh's sizes contradict each other");
  GridMesh mesh{.origin = Eigen::Map<const Eigen::Vector3f>(header.origin), .step = header.step};
  if (!mesh.origin.array().isFinite().all() || !(mesh.step > 0 && mesh.step < 1e30f))
    throw std::runtime_error("the mesh's grid is not valid");
  mesh.triangles = decode_triangles(bytes.substr(0, header.index_bytes), header.triangles, header.vertices);
  mesh.points.resize(header.vertices);
  BitModel bits(kContexts);
  ContextDecoder coder(bits, bytes.substr(header.index_bytes));
  PointCoder(mesh.triangles, mesh.points).code(coder);
  return mesh;
}

}  // namespace sheen
