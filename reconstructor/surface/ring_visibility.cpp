// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/ring_visibility.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace sheen {

RingVisibility::RingVisibility(const Mesh& mesh, const VertexRings& rings, const VisibilityOptions& options)
    : mesh_(mesh), rings_(rings), options_(options), scene_(mesh) {
  view_.pixel.resize(rings.total_samples());
  view_.visible.resize(rings.total_samples());
  view_.visible_in_triangle.resize(mesh.triangles.size());
  view_.cosine.resize(mesh.triangles.size());
  view_.step_px.resize(mesh.triangles.size());
}

const SurfaceView& RingVisibility::look(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask) {
  view_.eye = camera_centre(camera_from_object);
  cast_depth(camera, camera_from_object);
  mark_solid(camera, mask);
  test_samples(camera, camera_from_object);
  view_.visible_samples =
      std::accumulate(view_.visible_in_triangle.begin(), view_.visible_in_triangle.end(), std::size_t{0});
  return view_;
}

void RingVisibility::cast_depth(const Camera& camera, const Rigid3& camera_from_object) {
  const int w = camera.width, h = camera.height;
  if (!(camera == rays_of_)) {
    rays_.resize(std::size_t(w) * h);
    tbb::parallel_for(0, h, [&](int y) {
      for (int x = 0; x < w; ++x) {
        const auto ray = camera.ray({double(x), double(y)});
        rays_[std::size_t(y) * w + x] = ray && ray->z() > 1e-3
                                            ? Eigen::Vector3f((*ray / ray->z()).cast<float>())
                                            : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
      }
    });
    rays_of_ = camera;
    depth_ = ImageF(w, h, 1);
    solid_ = ImageU8(w, h, 1);
  }
  box_ = {w, h, 0, 0};
  for (const Eigen::Vector3f& vertex : mesh_.vertices) {
    const auto p = camera.project(camera_from_object * vertex.cast<double>());
    if (!p) continue;
    box_.x0 = std::min(box_.x0, static_cast<int>(std::clamp(p->x() - 2, 0.0, double(w))));
    box_.y0 = std::min(box_.y0, static_cast<int>(std::clamp(p->y() - 2, 0.0, double(h))));
    box_.x1 = std::max(box_.x1, static_cast<int>(std::clamp(p->x() + 3, 0.0, double(w))));
    box_.y1 = std::max(box_.y1, static_cast<int>(std::clamp(p->y() + 3, 0.0, double(h))));
  }
  std::fill_n(depth_.data(), depth_.size(), 0.0f);
  if (box_.x0 >= box_.x1 || box_.y0 >= box_.y1) return;

  const Rigid3 object_from_camera = camera_from_object.inverse();
  const Eigen::Matrix3f rotation = object_from_camera.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f eye = object_from_camera.translation.cast<float>();
  tbb::parallel_for(tbb::blocked_range<int>(box_.y0, box_.y1, 16), [&](const tbb::blocked_range<int>& range) {
    const int n = box_.x1 - box_.x0;
    std::vector<Ray> rays(n);
    std::vector<Hit> hits(n);
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int i = 0; i < n; ++i) {
        const Eigen::Vector3f& ray = rays_[std::size_t(y) * w + box_.x0 + i];
        rays[i] = std::isnan(ray.x()) ? Ray{eye, {0, 0, 1}, 0, -1} : Ray{eye, rotation * ray};
      }
      scene_.intersect(rays, hits);
      float* out = depth_.row(y) + box_.x0;
      for (int i = 0; i < n; ++i) out[i] = hits[i] && hits[i].front ? hits[i].distance : 0;  // rays have z = 1
    }
  });
}

void RingVisibility::mark_solid(const Camera& camera, const ImageU8& mask) {
  const int w = camera.width, h = camera.height, r = options_.erosion_px;
  const auto footprint = static_cast<float>(options_.depth_step / std::min(camera.fx, camera.fy));
  std::fill_n(solid_.data(), solid_.size(), std::uint8_t{0});
  const Box inner{std::max(box_.x0, 1), std::max(box_.y0, 1), std::min(box_.x1, w - 1), std::min(box_.y1, h - 1)};
  if (inner.x0 >= inner.x1 || inner.y0 >= inner.y1) return;
  ImageU8 smooth(w, h, 1);
  tbb::parallel_for(inner.y0, inner.y1, [&](int y) {
    for (int x = inner.x0; x < inner.x1; ++x) {
      const float z = depth_.at(x, y);
      const auto ignored = [&](int px, int py) { return !mask.empty() && mask.at(px, py) == 0; };
      if (z <= 0 || ignored(x, y)) continue;
      const float limit = footprint * z;
      const auto step = [&](int dx, int dy) {
        return std::abs(depth_.at(x + dx, y + dy) - z) > limit || ignored(x + dx, y + dy);
      };
      // Diagonals too: the cubic kernel reads two pixels away in both directions at once.
      smooth.at(x, y) = !(step(-1, 0) || step(1, 0) || step(0, -1) || step(0, 1) || step(-1, -1) || step(1, -1) ||
                          step(-1, 1) || step(1, 1));
    }
  });
  // Minimum over a square window, one direction after the other.
  ImageU8 narrow(w, h, 1);
  tbb::parallel_for(inner.y0, inner.y1, [&](int y) {
    int run = 0;  // of smooth pixels that ends at x
    for (int x = inner.x0; x < inner.x1; ++x) {
      run = smooth.at(x, y) ? run + 1 : 0;
      if (run > 2 * r) narrow.at(x - r, y) = 1;
    }
  });
  tbb::parallel_for(tbb::blocked_range<int>(inner.x0, inner.x1, 64), [&](const tbb::blocked_range<int>& range) {
    std::vector<int> run(range.size(), 0);
    for (int y = inner.y0; y < inner.y1; ++y)
      for (int x = range.begin(); x < range.end(); ++x) {
        int& length = run[x - range.begin()];
        length = narrow.at(x, y) ? length + 1 : 0;
        if (length > 2 * r) solid_.at(x, y - r) = 1;
      }
  });
}

void RingVisibility::test_samples(const Camera& camera, const Rigid3& camera_from_object) {
  const auto tolerance = static_cast<float>(options_.depth_tolerance / std::min(camera.fx, camera.fy));
  const Eigen::Vector3f eye = view_.eye.cast<float>();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh_.triangles.size(), 256), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      const std::size_t first = rings_.first_sample(t);
      const int n = rings_.resolution(t), samples = lattice_samples(n);
      const Eigen::Vector3f normal = mesh_.area_normal(t);
      const Eigen::Vector3f centre = (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3;
      const Eigen::Vector3f to_eye = eye - centre;
      view_.cosine[t] = normal.dot(to_eye) / std::max(normal.norm() * to_eye.norm(), 1e-30f);
      view_.visible_in_triangle[t] = 0;
      view_.step_px[t] = 0;
      std::fill_n(view_.visible.begin() + first, samples, std::uint8_t{0});
      if (view_.cosine[t] < options_.min_cosine) continue;

      const Eigen::Vector3d a = camera_from_object * mesh_.corner(t, 0).template cast<double>();
      const Eigen::Vector3d b = camera_from_object * mesh_.corner(t, 1).template cast<double>();
      const Eigen::Vector3d c = camera_from_object * mesh_.corner(t, 2).template cast<double>();
      int visible = 0;
      std::size_t s = first;
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j, ++s) {
          const double u = double(i) / (n - 1), v = double(j) / (n - 1);
          const Eigen::Vector3d p = a + u * (b - a) + v * (c - a);
          const auto pixel = camera.project(p);
          if (!pixel || !camera.contains(*pixel, 1)) continue;
          view_.pixel[s] = pixel->template cast<float>();
          const int x = static_cast<int>(pixel->x() + 0.5), y = static_cast<int>(pixel->y() + 0.5);
          if (!solid_.at(x, y)) continue;
          const auto z = static_cast<float>(p.z());
          if (z > depth_.at(x, y) + tolerance * z) continue;
          view_.visible[s] = 1;
          ++visible;
        }
      view_.visible_in_triangle[t] = visible;
      if (visible > 0) {
        const double f = std::sqrt(camera.fx * camera.fy), z = (a.z() + b.z() + c.z()) / 3;
        const double area_px = 0.5 * normal.norm() * view_.cosine[t] * f * f / (z * z);
        view_.step_px[t] = static_cast<float>(std::sqrt(2 * area_px) / (n - 1));
      }
    }
  });
}

}  // namespace sheen
