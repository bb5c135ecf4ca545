// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/camera/posed_camera.h"
#include "common/datasets/colmap_writer.h"
#include "common/geometry/mesh.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"

namespace sheen {

/// Points of a mesh, its vertices, with the mean colour that photographs show of them: what programs begin with that
/// look for a surface themselves.
class SurfacePoints {
 public:
  static constexpr std::size_t kMost = 100'000;  ///< of a finer mesh every so manieth vertex is one

  explicit SurfacePoints(Mesh mesh);

  /// `picture`: sRGB, 3 channels; `mask`: empty, or 0 = ignore. `from`: in the frame of the mesh's file.
  void look(const ImageU8& picture, const ImageU8& mask, const PosedCamera& from);

  /// In the frame of the mesh's file. A point that no picture shows is grey.
  std::vector<ColouredPoint> points() const;

 private:
  struct Point {
    Eigen::Vector3f place, normal;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int pictures = 0;
  };
  Eigen::Vector3d origin_;
  RayScene scene_;
  std::vector<Point> points_;
};

/// Binary little-endian PLY of points: x y z red green blue. Throws FileError.
void write_point_cloud(const std::filesystem::path& file, const std::vector<ColouredPoint>& points);

}  // namespace sheen
