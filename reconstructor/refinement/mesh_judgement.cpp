// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_judgement.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"
#include "reconstructor/refinement/grey_pyramid.h"

namespace sheen {
namespace {

constexpr std::size_t kFewImages = 32;  // of which more judge
constexpr std::size_t kSources = 4;     // images that predict a pixel
constexpr float kEdge_px = 3;           // without a mask: what an outline is off by
constexpr float kOffBackground = 0.1f;  // encoded: less than a surface in the wrong place is, more than in the right
constexpr float kVisible = 0.01f;       // of the distance: by how much a ray may meet the surface before the point
constexpr float kLeastAngle = 0.01f;    // radians; closer images are no better

struct Source {
  PosedCamera view;
  Eigen::Vector3f eye;
  GreyPyramid image;
};

/// The images that see the object from the sides nearest to that of a view.
std::vector<Source> nearest_sources(const RefinementImages& images, const PosedCamera& view,
                                    const Eigen::Vector3d& centre, const std::vector<std::size_t>& others) {
  const auto direction = [&](const PosedCamera& of) {
    return (camera_centre(of.camera_from_object) - centre).normalized();
  };
  std::vector<std::size_t> nearest = others;
  const std::size_t count = std::min(kSources, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), nearest.end(),
                    [&](std::size_t a, std::size_t b) {
                      return direction(images.cameras[a]).dot(direction(view)) >
                             direction(images.cameras[b]).dot(direction(view));
                    });
  std::vector<Source> sources;
  for (std::size_t i = 0; i < count; ++i) {
    const PosedCamera& of = images.cameras[nearest[i]];
    sources.push_back({of, camera_centre(of.camera_from_object).cast<float>(), GreyPyramid(images.read(nearest[i]))});
  }
  return sources;
}

/// What the sources show at the surface that a ray meets; empty where it meets none, NaN where no source sees the
/// place.
std::optional<float> predicted(const RayScene& scene, const Ray& ray, const std::vector<Source>& sources) {
  const Hit hit = scene.intersect(ray);
  if (!hit || !hit.front) return {};
  const Eigen::Vector3f point = ray.origin + hit.distance * ray.direction;
  const Eigen::Vector3f to_eye = (ray.origin - point).normalized();
  float sum = 0, weights = 0;
  for (const Source& source : sources) {
    const auto pixel = source.view.camera.project(source.view.camera_from_object * point.cast<double>());
    if (!pixel || scene.occluded(Ray{source.eye, point - source.eye, 0, 1 - kVisible})) continue;
    const float value = source.image.sample(0, static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
    if (!std::isfinite(value)) continue;
    const float cosine = std::clamp(to_eye.dot((source.eye - point).normalized()), -1.0f, 1.0f);
    const float weight = 1 / (kLeastAngle + std::acos(cosine));
    sum += weight * value;
    weights += weight;
  }
  return weights > 0 ? sum / weights : std::numeric_limits<float>::quiet_NaN();
}

/// Gain of the refined mesh at one image, dB; empty where no pixel can be judged.
std::optional<double> gain_at(const Capture& capture, const PosedCamera& view, const ImageF& inside,
                              const RayScene& given, const RayScene& refined, const std::vector<Source>& sources) {
  const Rigid3 object_from_camera = view.camera_from_object.inverse();
  const GreyPyramid truth(capture);
  const bool masked = !capture.mask.empty();
  const float least = masked ? 0 : kEdge_px;
  struct Errors {
    double given = 0, refined = 0;
  };
  std::vector<Errors> rows(inside.height());
  tbb::parallel_for(0, inside.height() - 1, [&](int y) {
    for (int x = 0; x + 1 < inside.width(); ++x) {
      const float grey = truth.sample(0, static_cast<float>(x), static_cast<float>(y));
      const auto direction = view.camera.ray({double(x), double(y)});
      if (inside.at(x, y) <= least || !std::isfinite(grey) || !direction) continue;
      const Ray ray{object_from_camera.translation.cast<float>(),
                    (object_from_camera.rotation * *direction).cast<float>()};
      // The object is in a mask for certain. Elsewhere it may be the background's turn, of which no mesh knows.
      const float nothing = masked ? grey : kOffBackground;
      const auto off = [&](const RayScene& scene) {
        const std::optional<float> value = predicted(scene, ray, sources);
        return double(value ? *value - grey : nothing);
      };
      const double off_given = off(given), off_refined = off(refined);
      if (!std::isfinite(off_given) || !std::isfinite(off_refined)) continue;
      rows[y].given += off_given * off_given;
      rows[y].refined += off_refined * off_refined;
    }
  });
  Errors sum;
  for (const Errors& row : rows) {
    sum.given += row.given;
    sum.refined += row.refined;
  }
  if (!(sum.given > 0 && sum.refined > 0)) return {};
  return 10 * std::log10(sum.given / sum.refined);
}

}  // namespace

MeshJudgement judge_mesh(const Mesh& given, const Mesh& refined, const RefinementImages& images,
                         const std::vector<std::size_t>& left_out, const std::vector<std::size_t>& others,
                         const StepsDone& progress) {
  const RayScene given_scene(given), refined_scene(refined);
  const Eigen::Vector3d centre = bounding_sphere(given).centre;
  SilhouetteCaster caster;
  MeshJudgement judgement;
  double squares = 0;
  std::size_t done = 0;
  for (const std::size_t i : left_out) {
    if (progress) progress(done++, left_out.size());
    const PosedCamera& view = images.cameras[i];
    const ImageF inside = distance_from_outline(caster.cast(view, given, given_scene));
    const auto gain = gain_at(images.read(i), view, inside, given_scene, refined_scene,
                              nearest_sources(images, view, centre, others));
    if (!gain) continue;
    ++judgement.images;
    judgement.gain_db += *gain;
    squares += *gain * *gain;
  }
  if (judgement.images == 0) return judgement;
  const auto n = static_cast<double>(judgement.images);
  judgement.gain_db /= n;
  if (judgement.images > 1)
    judgement.standard_error = std::sqrt(std::max(0.0, squares / n - std::pow(judgement.gain_db, 2)) / (n - 1));
  return judgement;
}

JudgedMesh refine_and_judge(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress) {
  std::vector<std::size_t> left_out, others;
  RefinementImages fitted;
  const std::size_t every = images.cameras.size() < kFewImages ? 4 : 8;
  for (std::size_t i = 0; i < images.cameras.size(); ++i) {
    if (i % every == every / 2) {
      left_out.push_back(i);
      continue;
    }
    others.push_back(i);
    fitted.cameras.push_back(images.cameras[i]);
  }
  fitted.read = [&](std::size_t i) { return images.read(others[i]); };
  std::vector<UnmaskedOutlines> ways{UnmaskedOutlines::kAsGiven};
  if (!images.masked) ways.push_back(UnmaskedOutlines::kFromEdges);
  std::optional<JudgedMesh> best;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    std::size_t steps_of_one = 0;
    const StepsDone part_done = [&](std::size_t done, std::size_t steps) {
      steps_of_one = steps;
      if (progress) progress(way * steps + done, ways.size() * steps);
    };
    const StepsDone judging = [&](std::size_t, std::size_t) { part_done(steps_of_one, steps_of_one); };
    JudgedMesh judged{.refined = refine_mesh(mesh, fitted, ways[way], part_done)};
    judged.judgement = judge_mesh(mesh, judged.refined.mesh, images, left_out, others, judging);
    if (!best || judged.judgement.gain_db > best->judgement.gain_db) best = std::move(judged);
  }
  best->left_out = std::move(left_out);
  best->others = std::move(others);
  return *std::move(best);
}

}  // namespace sheen
