// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/photographs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/image/color.h"
#include "reconstructor/numerics/view_kernel.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/edge_fill.h"

namespace sheen {
namespace {

constexpr int kLumigraphViews = 4;
constexpr int kReach = 2;  // of the cubic kernel, in pixels beyond the nearest one

class PhotographShader : public ViewShader {
 public:
  PhotographShader(std::shared_ptr<const PhotographSet> photographs, std::unique_ptr<ViewShader> where_unseen,
                   const Eigen::Vector3d& eye, int count)
      : photographs_(std::move(photographs)), where_unseen_(std::move(where_unseen)), eye_(eye), count_(count) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const Mesh& mesh = photographs_->mesh();
    const Eigen::Vector3f point =
        (1 - u - v) * mesh.corner(triangle, 0) + u * mesh.corner(triangle, 1) + v * mesh.corner(triangle, 2);
    Eigen::Vector3f encoded;
    if (!photographs_->blend(triangle, point.cast<double>(), eye_, count_, encoded))
      return {where_unseen_->shade(triangle, u, v).rgb, SampleState::kUnseen};
    return {encoded.unaryExpr(&srgb_decode), SampleState::kMeasured};
  }
  SurfaceQuality quality(std::uint32_t) const override { return {true, 0, 1, 1}; }  // it claims nothing

 private:
  std::shared_ptr<const PhotographSet> photographs_;
  std::unique_ptr<ViewShader> where_unseen_;
  Eigen::Vector3d eye_;
  int count_;
};

class PhotographModel : public Appearance {
 public:
  PhotographModel(std::shared_ptr<const PhotographSet> photographs, std::shared_ptr<const Appearance> where_unseen,
                  int count)
      : photographs_(std::move(photographs)), where_unseen_(std::move(where_unseen)), count_(count) {}

  const Mesh& mesh() const override { return photographs_->mesh(); }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override {
    return std::make_unique<PhotographShader>(photographs_, where_unseen_->shader_for(query), query.eye, count_);
  }

 private:
  std::shared_ptr<const PhotographSet> photographs_;
  std::shared_ptr<const Appearance> where_unseen_;
  int count_;
};

/// Weights of cubic convolution (Catmull-Rom) for the pixels -1, 0, 1, 2 round a place t in [0, 1) beyond pixel 0.
Eigen::Array4f cubic_weights(float t) {
  return 0.5f *
         Eigen::Array4f{((2 - t) * t - 1) * t, (3 * t - 5) * t * t + 2, ((4 - 3 * t) * t + 1) * t, (t - 1) * t * t};
}

Eigen::Array4f linear_weights(float t) {
  return {0, 1 - t, t, 0};
}

/// Encoded colour, 0..1, at a place of the cut-out.
Eigen::Vector3f sample(const ImageU8& pixels, float x, float y, Eigen::Array4f (*weights)(float)) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const Eigen::Array4f wx = weights(x - x0), wy = weights(y - y0);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const std::uint8_t* pixel =
          pixels.pixel(std::clamp(x0 - 1 + i, 0, pixels.width() - 1), std::clamp(y0 - 1 + j, 0, pixels.height() - 1));
      sum += wx[i] * wy[j] * Eigen::Vector3f(pixel[0], pixel[1], pixel[2]);
    }
  return (sum / 255).cwiseMax(0).cwiseMin(1);
}

/// Encoded colour of a photograph at a point it shows safely.
std::optional<Eigen::Vector3f> look_up(const Photograph& photograph, const Eigen::Vector3d& point, double tolerance) {
  const Eigen::Vector3d p = photograph.camera_from_object * point;
  const auto pixel = photograph.camera.project(p);
  if (!pixel || !photograph.camera.contains(*pixel, 1)) return std::nullopt;
  const int x = static_cast<int>(pixel->x() + 0.5) - photograph.left,
            y = static_cast<int>(pixel->y() + 0.5) - photograph.top;
  if (x < 0 || y < 0 || x >= photograph.depth.width() || y >= photograph.depth.height()) return std::nullopt;
  const double depth = photograph.depth.at(x, y);
  if (depth <= 0 || p.z() > depth + tolerance * p.z()) return std::nullopt;
  // Beside an edge as the light field: linearly, since the cubic kernel would read beyond the edge.
  return sample(photograph.pixels, static_cast<float>(pixel->x() - photograph.left),
                static_cast<float>(pixel->y() - photograph.top),
                photograph.from_edge.at(x, y) == 2 ? cubic_weights : linear_weights);
}

}  // namespace

std::optional<Photograph> cut_out(const Capture& capture, const ImageF& linear, const SurfaceView& view) {
  const ImageF& depth = view.safe_depth;
  const int w = depth.width(), h = depth.height();
  int x0 = w, y0 = h, x1 = 0, y1 = 0;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (depth.at(x, y) > 0) {
        x0 = std::min(x0, std::max(x - kReach, 0));
        y0 = std::min(y0, std::max(y - kReach, 0));
        x1 = std::max(x1, std::min(x + kReach + 1, w));
        y1 = std::max(y1, std::min(y + kReach + 1, h));
      }
  if (x0 >= x1) return std::nullopt;
  Photograph photograph{.camera = capture.camera,
                        .camera_from_object = capture.pose.camera_from_object,
                        .eye = camera_centre(capture.pose.camera_from_object),
                        .left = x0,
                        .top = y0,
                        .pixels = ImageU8(x1 - x0, y1 - y0, 3),
                        .depth = ImageF(x1 - x0, y1 - y0, 1),
                        .from_edge = ImageU8(x1 - x0, y1 - y0, 1)};
  ImageF cut(x1 - x0, y1 - y0, 3);
  for (int y = y0; y < y1; ++y) std::copy_n(linear.pixel(x0, y), 3 * cut.width(), cut.row(y - y0));
  fill_edges(view.from_edge, x0, y0, cut);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      for (int c = 0; c < 3; ++c)
        photograph.pixels.at(x - x0, y - y0, c) = static_cast<std::uint8_t>(
            std::lround(255 * std::clamp(srgb_encode(cut.at(x - x0, y - y0, c)), 0.0f, 1.0f)));
      photograph.depth.at(x - x0, y - y0) = depth.at(x, y);
      photograph.from_edge.at(x - x0, y - y0) = view.from_edge.at(x, y);
    }
  return photograph;
}

PhotographCutter::PhotographCutter(const Mesh& mesh)
    : corners_(std::vector<std::uint8_t>(mesh.triangles.size(), 2)), visibility_(mesh, corners_, {}) {}

std::optional<Photograph> PhotographCutter::cut(const Capture& capture, float gain) {
  const SurfaceView& view = visibility_.look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  return cut_out(capture, level_radiance(capture, gain), view);
}

void PhotographSet::add(const Capture& capture, const ImageF& linear, const SurfaceView& view) {
  if (std::optional<Photograph> photograph = cut_out(capture, linear, view))
    photographs_.push_back(*std::move(photograph));
}

std::size_t PhotographSet::pixel_bytes() const {
  std::size_t bytes = 0;
  for (const Photograph& photograph : photographs_) bytes += photograph.pixels.size();
  return bytes;
}

std::size_t PhotographSet::memory_bytes() const {
  std::size_t bytes = pixel_bytes();
  for (const Photograph& photograph : photographs_)
    bytes += photograph.depth.size() * sizeof(float) + photograph.from_edge.size();
  return bytes;
}

bool PhotographSet::blend(std::uint32_t triangle, const Eigen::Vector3d& point, const Eigen::Vector3d& eye, int count,
                          Eigen::Vector3f& encoded) const {
  const Eigen::Vector3d normal = mesh_->area_normal(triangle).cast<double>().normalized();
  const Eigen::Vector3f to_eye = (eye - point).normalized().cast<float>();
  struct Candidate {
    float cosine;
    const Photograph* photograph;
    bool operator<(const Candidate& other) const { return cosine > other.cosine; }
  };
  thread_local std::vector<Candidate> candidates;
  candidates.clear();
  for (const Photograph& photograph : photographs_) {
    const Eigen::Vector3d direction = (photograph.eye - point).normalized();
    if (normal.dot(direction) < options_.min_cosine) continue;
    candidates.push_back({to_eye.dot(direction.cast<float>()), &photograph});
  }
  std::sort(candidates.begin(), candidates.end());

  Eigen::Vector3f colour[kLumigraphViews];
  float angle[kLumigraphViews + 1];
  int found = 0;
  for (const Candidate& candidate : candidates) {
    const Photograph& photograph = *candidate.photograph;
    const double tolerance = options_.depth_tolerance / std::min(photograph.camera.fx, photograph.camera.fy);
    const auto value = look_up(photograph, point, tolerance);
    if (!value) continue;
    angle[found] = angle_between(to_eye, (photograph.eye - point).normalized().cast<float>());
    if (found < count) colour[found] = *value;
    if (++found > count || count == 1) break;
  }
  if (found == 0) return false;
  const int used = std::min(found, count);
  // With no further photograph the farthest one that is used must not get weight 0.
  constexpr float kLastOne = 1.5f, kSameEye = 1e-4f;
  const float limit = found > count ? angle[count] : kLastOne * angle[used - 1];
  float total = 0;
  encoded.setZero();
  for (int j = 0; j < used; ++j) {
    const float weight = (1 - angle[j] / std::max(limit, kSameEye)) / std::max(angle[j], kSameEye);
    encoded += weight * colour[j];
    total += weight;
  }
  if (total > 0)
    encoded /= total;
  else  // all as far as the next one
    encoded = colour[0];
  return true;
}

std::shared_ptr<const Appearance> PhotographSet::nearest_photograph(std::shared_ptr<const PhotographSet> photographs,
                                                                    std::shared_ptr<const Appearance> where_unseen) {
  return std::make_shared<PhotographModel>(std::move(photographs), std::move(where_unseen), 1);
}

std::shared_ptr<const Appearance> PhotographSet::unstructured_lumigraph(
    std::shared_ptr<const PhotographSet> photographs, std::shared_ptr<const Appearance> where_unseen) {
  return std::make_shared<PhotographModel>(std::move(photographs), std::move(where_unseen), kLumigraphViews);
}

}  // namespace sheen
