// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/left_out_gain.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <utility>

namespace sheen {
namespace {

constexpr std::size_t kFewImages = 32;  // of which more judge
constexpr std::size_t kSources = 4;     // images that predict a pixel
constexpr float kEdge_px = 3;           // without a mask: what an outline is off by
constexpr float kOffBackground = 0.1f;  // encoded: less than a surface in the wrong place is, more than in the right
constexpr float kVisible = 0.01f;       // of the distance: by how much a ray may meet the surface before the point
constexpr float kLeastAngle = 0.01f;    // radians; closer images are no better

/// What the sources show at the surface that a ray meets; empty where it meets none, NaN where no source sees the
/// place.
std::optional<float> predicted(const RayScene& scene, const Ray& ray, std::span<const SourceImage> sources) {
  const Hit hit = scene.intersect(ray);
  if (!hit || !hit.front) return {};
  const Eigen::Vector3f point = ray.origin + hit.distance * ray.direction;
  const Eigen::Vector3f to_eye = (ray.origin - point).normalized();
  float sum = 0, weights = 0;
  for (const SourceImage& source : sources) {
    const auto pixel = source.view.camera.project(source.view.camera_from_object * point.cast<double>());
    const Eigen::Vector3f& eye = source.eye;
    if (!pixel || scene.occluded(Ray{eye, point - eye, 0, 1 - kVisible})) continue;
    const float value = source.image.sample(0, static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
    if (!std::isfinite(value)) continue;
    const float cosine = std::clamp(to_eye.dot((eye - point).normalized()), -1.0f, 1.0f);
    const float weight = 1 / (kLeastAngle + std::acos(cosine));
    sum += weight * value;
    weights += weight;
  }
  return weights > 0 ? sum / weights : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

LeftOut leave_out_some(std::size_t images) {
  LeftOut numbers;
  const std::size_t every = images < kFewImages ? 4 : 8;
  for (std::size_t i = 0; i < images; ++i) (i % every == every / 2 ? numbers.left_out : numbers.others).push_back(i);
  return numbers;
}

std::vector<SourceImage> nearest_sources(const RefinementImages& images, const PosedCamera& view,
                                         const Eigen::Vector3d& centre, const std::vector<std::size_t>& among) {
  const auto direction = [&](const PosedCamera& of) {
    return (camera_centre(of.camera_from_object) - centre).normalized();
  };
  std::vector<std::size_t> nearest = among;
  const std::size_t count = std::min(kSources, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), nearest.end(),
                    [&](std::size_t a, std::size_t b) {
                      return direction(images.cameras[a]).dot(direction(view)) >
                             direction(images.cameras[b]).dot(direction(view));
                    });
  std::vector<SourceImage> sources;
  for (std::size_t i = 0; i < count; ++i) {
    sources.push_back({nearest[i], GreyPyramid(images.read(nearest[i])), images.cameras[nearest[i]]});
  }
  return sources;
}

std::optional<double> gain_at(const Capture& capture, const ImageF& inside, const ImagePrediction& before,
                              const ImagePrediction& after) {
  const GreyPyramid truth(capture);
  const bool masked = !capture.mask.empty();
  const float least = masked ? 0 : kEdge_px;
  /// What a prediction is off by at a pixel.
  const auto off = [&](const ImagePrediction& by, const Rigid3& object_from_camera, int x, int y, float grey) {
    const auto direction = by.view.camera.ray({double(x), double(y)});
    if (!direction) return std::numeric_limits<double>::quiet_NaN();
    const Ray ray{object_from_camera.translation.cast<float>(),
                  (object_from_camera.rotation * *direction).cast<float>()};
    const std::optional<float> value = predicted(by.scene, ray, by.sources);
    // The object is in a mask for certain. Elsewhere it may be the background's turn, of which no mesh knows.
    return double(value ? *value - grey : masked ? grey : kOffBackground);
  };
  const Rigid3 from_before = before.view.camera_from_object.inverse();
  const Rigid3 from_after = after.view.camera_from_object.inverse();
  struct Errors {
    double before = 0, after = 0;
  };
  std::vector<Errors> rows(inside.height());
  tbb::parallel_for(0, inside.height() - 1, [&](int y) {
    for (int x = 0; x + 1 < inside.width(); ++x) {
      const float grey = truth.sample(0, static_cast<float>(x), static_cast<float>(y));
      if (inside.at(x, y) <= least || !std::isfinite(grey)) continue;
      const double off_before = off(before, from_before, x, y, grey), off_after = off(after, from_after, x, y, grey);
      if (!std::isfinite(off_before) || !std::isfinite(off_after)) continue;
      rows[y].before += off_before * off_before;
      rows[y].after += off_after * off_after;
    }
  });
  Errors sum;
  for (const Errors& row : rows) {
    sum.before += row.before;
    sum.after += row.after;
  }
  if (!(sum.before > 0 && sum.after > 0)) return {};
  return 10 * std::log10(sum.before / sum.after);
}

LeftOutGain mean_gain(const std::vector<std::size_t>& left_out,
                      const std::function<std::optional<double>(std::size_t)>& gain, const StepsDone& progress) {
  LeftOutGain mean;
  double squares = 0;
  std::size_t done = 0;
  for (const std::size_t i : left_out) {
    const std::optional<double> of_image = gain(i);
    if (progress) progress(++done, left_out.size());
    if (!of_image) continue;
    ++mean.images;
    mean.gain_db += *of_image;
    squares += *of_image * *of_image;
  }
  if (mean.images == 0) return mean;
  const auto n = static_cast<double>(mean.images);
  mean.gain_db /= n;
  if (mean.images > 1)
    mean.standard_error = std::sqrt(std::max(0.0, squares / n - std::pow(mean.gain_db, 2)) / (n - 1));
  return mean;
}

}  // namespace sheen
