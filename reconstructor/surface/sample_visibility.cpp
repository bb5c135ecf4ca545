// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/sample_visibility.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "reconstructor/surface/vertex_visibility.h"

namespace sheen {
SampleVisibility::SampleVisibility(const Mesh& mesh, const MapLayout& maps, const VisibilityOptions& options,
                                   std::shared_ptr<const RayScene> scene)
    : mesh_(mesh),
      maps_(&maps),
      options_(options),
      scene_(scene ? std::move(scene) : std::make_shared<const RayScene>(mesh)),
      projection_(mesh, maps) {
  view_.places = &projection_;
  view_.visible.resize(maps.total_samples());
  view_.visible_in_triangle.resize(mesh.triangles.size());
  view_.cosine.resize(mesh.triangles.size());
  view_.step_px.resize(mesh.triangles.size());
}

void SampleVisibility::use(const MapLayout& maps) {
  maps_ = &maps;
  projection_.use(maps);
  view_.visible.resize(maps.total_samples());
}

const SurfaceView& SampleVisibility::look(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask) {
  view_.eye = camera_centre(camera_from_object);
  cast_depth(camera, camera_from_object, mask);
  find_facing();
  projection_.use(camera, camera_from_object);
  if (options_.test == VisibilityTest::kSamples) {
    erode_depth(camera);
    test_samples(camera);
  } else {
    ignore_edges();
    test_vertices(camera, camera_from_object, mask);
  }
  view_.visible_samples =
      std::accumulate(view_.visible_in_triangle.begin(), view_.visible_in_triangle.end(), std::size_t{0});
  return view_;
}

void SampleVisibility::cast_depth(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask) {
  const int w = camera.width, h = camera.height;
  rays_.use(camera);
  if (view_.safe_depth.width() != w || view_.safe_depth.height() != h) {
    view_.safe_depth = ImageF(w, h, 1);
    view_.from_edge = smooth_ = narrow_ = ImageU8(w, h, 1);
  }
  view_.box = {w, h, 0, 0};
  for (const Eigen::Vector3f& vertex : mesh_.vertices) {
    const auto p = camera.project(camera_from_object * vertex.cast<double>());
    if (!p) continue;
    view_.box.x0 = std::min(view_.box.x0, static_cast<int>(std::clamp(p->x() - 2, 0.0, double(w))));
    view_.box.y0 = std::min(view_.box.y0, static_cast<int>(std::clamp(p->y() - 2, 0.0, double(h))));
    view_.box.x1 = std::max(view_.box.x1, static_cast<int>(std::clamp(p->x() + 3, 0.0, double(w))));
    view_.box.y1 = std::max(view_.box.y1, static_cast<int>(std::clamp(p->y() + 3, 0.0, double(h))));
  }
  std::fill_n(view_.safe_depth.data(), view_.safe_depth.size(), 0.0f);
  if (view_.box.x0 >= view_.box.x1 || view_.box.y0 >= view_.box.y1) return;

  const Rigid3 object_from_camera = camera_from_object.inverse();
  const Eigen::Matrix3f rotation = object_from_camera.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f eye = object_from_camera.translation.cast<float>();
  tbb::parallel_for(tbb::blocked_range<int>(view_.box.y0, view_.box.y1, 16), [&](const tbb::blocked_range<int>& range) {
    const int n = view_.box.x1 - view_.box.x0;
    std::vector<Eigen::Vector3f> directions(n);
    std::vector<Ray> rays(n);
    std::vector<Hit> hits(n);
    for (int y = range.begin(); y < range.end(); ++y) {
      rays_.read(view_.box.x0, y, directions);
      for (int i = 0; i < n; ++i)
        rays[i] = std::isnan(directions[i].x()) ? Ray{eye, {0, 0, 1}, 0, -1} : Ray{eye, rotation * directions[i]};
      scene_->intersect(rays, hits);
      float* out = view_.safe_depth.row(y) + view_.box.x0;
      for (int i = 0; i < n; ++i) out[i] = hits[i] && hits[i].front ? hits[i].distance : 0;  // rays have z = 1
      if (mask.empty()) continue;
      for (int i = 0; i < n; ++i)
        if (mask.at(view_.box.x0 + i, y) == 0) out[i] = -out[i];
    }
  });
}

void SampleVisibility::erode_depth(const Camera& camera) {
  const int w = camera.width, h = camera.height, r = options_.erosion_px;
  const auto footprint = static_cast<float>(options_.depth_step / std::min(camera.fx, camera.fy));
  ImageF& depth = view_.safe_depth;
  std::fill_n(view_.from_edge.data(), view_.from_edge.size(), std::uint8_t{0});
  const PixelBox inner{std::max(view_.box.x0, 1), std::max(view_.box.y0, 1), std::min(view_.box.x1, w - 1),
                       std::min(view_.box.y1, h - 1)};
  if (inner.empty()) {
    std::fill_n(depth.data(), depth.size(), 0.0f);
    return;
  }
  std::fill_n(smooth_.data(), smooth_.size(), std::uint8_t{0});
  std::fill_n(narrow_.data(), narrow_.size(), std::uint8_t{0});
  tbb::parallel_for(tbb::blocked_range<int>(inner.y0, inner.y1, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const float *above = depth.row(y - 1), *row = depth.row(y), *below = depth.row(y + 1);
      std::uint8_t* out = smooth_.row(y);
      for (int x = inner.x0; x < inner.x1; ++x) {
        const float z = row[x], limit = footprint * z;
        const auto near = [&](float other) { return std::abs(other - z) <= limit; };
        // Diagonals too: a pixel may straddle an edge with its corner.
        out[x] = (z > 0) & near(row[x - 1]) & near(row[x + 1]) & near(above[x]) & near(below[x]) & near(above[x - 1]) &
                 near(above[x + 1]) & near(below[x - 1]) & near(below[x + 1]);
      }
    }
  });
  tbb::parallel_for(tbb::blocked_range<int>(inner.y0, inner.y1, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const std::uint8_t *above = smooth_.row(y - 1), *row = smooth_.row(y), *below = smooth_.row(y + 1);
      std::uint8_t* out = view_.from_edge.row(y);
      for (int x = inner.x0; x < inner.x1; ++x)
        out[x] = row[x] + (row[x] & row[x - 1] & row[x + 1] & above[x - 1] & above[x] & above[x + 1] & below[x - 1] &
                           below[x] & below[x + 1]);
    }
  });
  // Minimum over a square window, one direction after the other.
  tbb::parallel_for(inner.y0, inner.y1, [&](int y) {
    int run = 0;  // of smooth pixels that ends at x
    for (int x = inner.x0; x < inner.x1; ++x) {
      run = smooth_.at(x, y) ? run + 1 : 0;
      if (run > 2 * r) narrow_.at(x - r, y) = 1;
    }
  });
  std::fill_n(smooth_.data(), smooth_.size(), std::uint8_t{0});  // from here on: what is safe
  tbb::parallel_for(tbb::blocked_range<int>(inner.x0, inner.x1, 64), [&](const tbb::blocked_range<int>& range) {
    std::vector<int> run(range.size(), 0);
    for (int y = inner.y0; y < inner.y1; ++y)
      for (int x = range.begin(); x < range.end(); ++x) {
        int& length = run[x - range.begin()];
        length = narrow_.at(x, y) ? length + 1 : 0;
        if (length > 2 * r) smooth_.at(x, y - r) = 1;
      }
  });
  tbb::parallel_for(tbb::blocked_range<int>(view_.box.y0, view_.box.y1, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = view_.box.x0; x < view_.box.x1; ++x)
        if (!smooth_.at(x, y)) depth.at(x, y) = 0;
  });
}

void SampleVisibility::ignore_edges() {
  std::fill_n(view_.from_edge.data(), view_.from_edge.size(), std::uint8_t{2});
  for (std::size_t i = 0; i < view_.safe_depth.size(); ++i)
    view_.safe_depth.data()[i] = std::max(view_.safe_depth.data()[i], 0.0f);
}

void SampleVisibility::find_facing() {
  const Eigen::Vector3f eye = view_.eye.cast<float>();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh_.triangles.size(), 1024), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      const Eigen::Vector3f normal = mesh_.area_normal(t);
      const Eigen::Vector3f centre = (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3;
      const Eigen::Vector3f to_eye = eye - centre;
      view_.cosine[t] = normal.dot(to_eye) / std::max(normal.norm() * to_eye.norm(), 1e-30f);
    }
  });
}

float SampleVisibility::nearer(const Camera& camera) const {
  return static_cast<float>(1 - options_.depth_tolerance / std::min(camera.fx, camera.fy));
}

void SampleVisibility::test_samples(const Camera& camera) {
  const float closest = nearer(camera);
  const float* const safe_depth = view_.safe_depth.data();
  const std::ptrdiff_t width = view_.safe_depth.width();
  mark_samples(
      camera, [](std::size_t) { return true; },
      [=](int column, int row, float z) { return closest * z <= safe_depth[row * width + column]; });
}

void SampleVisibility::test_vertices(const Camera& camera, const Rigid3& camera_from_object, const ImageU8& mask) {
  const std::vector<std::uint8_t> visible =
      visible_vertices(mesh_, *scene_, camera, camera_from_object, mask, nearer(camera));
  mark_samples(
      camera,
      [&](std::size_t t) {
        const auto& [a, b, c] = mesh_.triangles[t];
        return visible[a] && visible[b] && visible[c];
      },
      [&](int column, int row, float) { return mask.empty() || mask.at(column, row) != 0; });
}

template <typename MayShow, typename Shows>
void SampleVisibility::mark_samples(const Camera& camera, MayShow&& may_show, Shows&& shows) {
  const auto largest_x = static_cast<float>(camera.width - 2), largest_y = static_cast<float>(camera.height - 2);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh_.triangles.size(), 64), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      const std::size_t first = maps_->first_sample(t);
      const int n = maps_->resolution(t);
      const std::size_t samples = lattice_samples(n);
      view_.visible_in_triangle[t] = 0;
      view_.step_px[t] = 0;
      std::fill_n(view_.visible.begin() + first, samples, std::uint8_t{0});
      if (view_.cosine[t] < options_.min_cosine || !may_show(t)) continue;

      const auto [x, y, z] = projection_.of(t);
      std::uint8_t* const shown = view_.visible.data() + first;
      int visible = 0;
      for (std::size_t s = 0; s < samples; ++s) {
        const bool inside = (x[s] >= 1) & (y[s] >= 1) & (x[s] <= largest_x) & (y[s] <= largest_y);
        const int column = inside ? static_cast<int>(x[s] + 0.5f) : 0, row = inside ? static_cast<int>(y[s] + 0.5f) : 0;
        const bool seen = inside & shows(column, row, z[s]);
        shown[s] = seen;
        visible += seen;
      }
      view_.visible_in_triangle[t] = visible;
      if (visible > 0) {
        const double f = std::sqrt(camera.fx * camera.fy), depth = (z[0] + z[n - 1] + z[samples - 1]) / 3;
        const double area_px = 0.5 * mesh_.area_normal(t).norm() * view_.cosine[t] * f * f / (depth * depth);
        view_.step_px[t] = static_cast<float>(std::sqrt(2 * area_px) / (maps_->filter_resolution(t) - 1));
      }
    }
  });
}

}  // namespace sheen
