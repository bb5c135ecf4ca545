// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/surface_points.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "common/base/files.h"
#include "common/capture/moved_origin.h"

namespace sheen {
namespace {

constexpr float kLeastCosine = 0.2f;         ///< between a point's normal and the direction to the camera
constexpr float kInFront = 0.998f;           ///< a surface nearer than this part of the way hides a point
constexpr std::uint8_t kUnseenColour = 128;  ///< grey

}  // namespace

SurfacePoints::SurfacePoints(Mesh mesh) : origin_(mesh.origin), scene_(mesh) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::size_t step = (mesh.vertices.size() + kMost - 1) / kMost;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) points_.push_back({mesh.vertices[i], normals[i]});
}

void SurfacePoints::look(const ImageU8& picture, const ImageU8& mask, const PosedCamera& from) {
  const PosedCamera camera = in_frame_at(origin_, from);
  const Eigen::Vector3f eye = camera_centre(camera.camera_from_object).cast<float>();
  tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t i) {
    Point& point = points_[i];
    const Eigen::Vector3f way = point.place - eye;
    if (-way.normalized().dot(point.normal) < kLeastCosine) return;
    const auto pixel = camera.camera.project(camera.camera_from_object * point.place.cast<double>());
    if (!pixel || !camera.camera.contains(*pixel)) return;
    const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
    if (!mask.empty() && mask.at(x, y) == 0) return;
    if (scene_.occluded({.origin = eye, .direction = way, .far = kInFront})) return;
    for (int c = 0; c < 3; ++c) point.sum[c] += picture.at(x, y, c);
    ++point.pictures;
  });
}

std::vector<ColouredPoint> SurfacePoints::points() const {
  std::vector<ColouredPoint> out;
  for (const Point& point : points_) {
    ColouredPoint& coloured = out.emplace_back();
    coloured.position = point.place.cast<double>() + origin_;
    coloured.colour.fill(kUnseenColour);
    for (std::size_t c = 0; c < 3 && point.pictures > 0; ++c)
      coloured.colour[c] = static_cast<std::uint8_t>(std::lround(point.sum[Eigen::Index(c)] / point.pictures));
  }
  return out;
}

void write_point_cloud(const std::filesystem::path& file, const std::vector<ColouredPoint>& points) {
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) out += std::string("property double ") + axis + "\n";
  for (const char* colour : {"red", "green", "blue"}) out += std::string("property uchar ") + colour + "\n";
  out += "end_header\n";
  for (const ColouredPoint& point : points) {
    out.append(reinterpret_cast<const char*>(point.position.data()), sizeof(point.position));
    out.append(reinterpret_cast<const char*>(point.colour.data()), point.colour.size());
  }
  write_file(file, out);
}

}  // namespace sheen
