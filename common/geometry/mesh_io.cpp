// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_io.h"

#include <charconv>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/length_limit.h"
#include "common/geometry/polygon.h"

namespace sheen {

namespace {
constexpr double kMaxIndex = 4294967294.0;     // 2^32 - 1 means "no hit" elsewhere
constexpr double kUnsignedEnd = 4294967295.0;  // of a strip: -1 in a list of uint
constexpr std::string_view kBlanks = " \t\r\v\f";
}  // namespace

void MeshBuilder::fail(FilePlace place, const std::string& what) const {
  throw FileError(path_, std::string(place.kind) + " " + std::to_string(place.number) + ": " + what);
}

void MeshBuilder::add_vertex(double x, double y, double z, FilePlace place) {
  const Eigen::Vector3d vertex(x, y, z);
  if (!(vertex.array().abs() <= kLongestLength).all()) fail(place, "a coordinate is not a finite number within 10^9 m");
  vertices_.push_back(vertex);
}

void MeshBuilder::add_face(std::span<const double> corners, FilePlace place) {
  for (const double corner : corners) {
    if (!(corner >= 0 && corner <= kMaxIndex && corner == std::floor(corner)))
      fail(place, "a corner is not a vertex index");
    if (corner >= largest_index_) {
      largest_index_ = static_cast<std::uint32_t>(corner);
      largest_place_ = place;
    }
  }
  if (corners.size() < 3) {
    ++empty_faces_;
    return;
  }
  for (const double corner : corners) corners_.push_back(static_cast<std::uint32_t>(corner));
  polygons_.push_back({place, static_cast<std::uint32_t>(corners.size())});
}

void MeshBuilder::add_strips(std::span<const double> corners, FilePlace place) {
  std::size_t first = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i] < 0 || corners[i] == kUnsignedEnd) first = i + 1;
    if (i < first + 2) continue;
    const double a = corners[i - 2], b = corners[i - 1], c = corners[i];
    if (a == b || b == c || c == a) continue;  // how strips go round a corner
    const double turned[] = {b, a, c}, straight[] = {a, b, c};
    add_face((i - first) % 2 == 1 ? turned : straight, place);
  }
}

std::vector<Triangle> MeshBuilder::triangles() const {
  std::vector<Triangle> triangles;
  triangles.reserve(polygons_.size());
  std::vector<Eigen::Vector3d> outline;
  const std::uint32_t* corner = corners_.data();
  for (const Polygon& polygon : polygons_) {
    outline.clear();
    for (std::uint32_t i = 0; i < polygon.size; ++i) outline.push_back(vertices_[corner[i]]);
    const auto split = polygon_triangles(outline);
    if (split.empty())
      fail(polygon.place, "a polygon of more than " + std::to_string(kMostCorners) +
                              " corners that is not convex; split it into triangles first");
    for (const auto& [a, b, c] : split) triangles.push_back({corner[a], corner[b], corner[c]});
    corner += polygon.size;
  }
  return triangles;
}

RawMesh MeshBuilder::finish() {
  if (vertices_.empty()) throw FileError(path_, "holds no vertex");
  if (polygons_.empty()) throw FileError(path_, "holds no triangle: a mesh is needed, not a point cloud");
  if (largest_index_ >= vertices_.size())
    fail(largest_place_, "refers to vertex " + std::to_string(largest_index_) + " (counted from 0), but there are " +
                             std::to_string(vertices_.size()));
  std::vector<Triangle> split = triangles();
  return {std::move(vertices_), std::move(split), origin_, empty_faces_};
}

WordReader::WordReader(std::string_view text, bool continuations) : rest_(text), continuations_(continuations) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

bool WordReader::next(std::vector<std::string_view>& words) {
  words.clear();
  bool continued = false;
  while (!rest_.empty() && (words.empty() || continued)) {
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_;
    if (words.empty()) first_line_ = line_;
    line = line.substr(0, line.find('#'));
    while (!line.empty() && kBlanks.find(line.back()) != std::string_view::npos) line.remove_suffix(1);
    continued = continuations_ && line.ends_with('\\');
    if (continued) line.remove_suffix(1);
    while (true) {
      const std::size_t begin = line.find_first_not_of(kBlanks);
      if (begin == std::string_view::npos) break;
      const std::size_t length = std::min(line.find_first_of(kBlanks, begin), line.size()) - begin;
      words.push_back(line.substr(begin, length));
      line.remove_prefix(begin + length);
    }
  }
  return !words.empty();
}

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace sheen
