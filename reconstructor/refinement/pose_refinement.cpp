// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/pose_refinement.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/refinement/patch_view.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {
namespace {

constexpr std::array kSpacings_px{4.0, 2.0, 1.0, 1.0};  // between the points of the patches, from coarse to fine
constexpr std::size_t kVertices = 8000;                 // at most, whose patches are looked at
constexpr float kClearance = 1.5f;                      // patch spacings by which the surface may be off
constexpr int kLeastImages = 2;                         // that show a patch beside the one that is moved
constexpr float kLeastAgreement = 0.5f;           // correlation with what the others show; else it is another thing
constexpr std::size_t kLeastPatches = 20;         // fewer do not determine a pose
constexpr double kGivenSigma_px = 3;              // of a pose before a pass, on the surface
constexpr double kMedianOfContradiction = 0.891;  // chi squared of six degrees of freedom, over six
constexpr double kCommonError_px = 0.2;           // what all images get wrong alike: halves cannot show it
constexpr int kSteps = 4;                         // of Gauss and Newton
constexpr float kDifference = 0.5f;               // of a step of the pyramid's level: to either side of a gradient

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Every so many vertices, and what all images show of their patches.
class PatchConsensus {
 public:
  PatchConsensus(const Mesh& mesh, const MeshEdges& edges, const std::vector<float>& footprints, double spacing_px)
      : mesh_(mesh), patches_(mesh, edges, spacings(footprints, spacing_px), 0), scene_(mesh) {
    const std::size_t every = 1 + mesh.vertices.size() / kVertices;
    for (std::size_t v = 0; v < mesh.vertices.size(); v += every) vertices_.push_back(v);
    sums_.resize(vertices_.size());
  }

  std::size_t size() const { return vertices_.size(); }
  /// How many of the patches see a place of the surface, in the mean.
  double overlap() const {
    double of_patches = 0, of_surface = 0;
    for (const std::size_t v : vertices_) of_patches += std::pow(kPatchSide * double(patches_.spacing[v]), 2);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) of_surface += 0.5 * mesh_.area_normal(t).norm();
    return std::max(1.0, of_patches / of_surface);
  }
  const Eigen::Vector3f& vertex(std::size_t number) const { return mesh_.vertices[vertices_[number]]; }

  std::optional<PatchView> look(const GreyPyramid& image, const PosedCamera& view, std::size_t number) const {
    return view_patch(view, vertex(number), patches_, vertices_[number], image, scene_, kClearance);
  }

  void add(const GreyPyramid& image, const PosedCamera& view) {
    tbb::parallel_for(std::size_t{0}, size(), [&](std::size_t i) {
      const auto seen = look(image, view, i);
      const auto patch = seen ? seen->sample(image, seen->pixel) : std::nullopt;
      if (!patch) return;
      sums_[i].patch += seen->cosine * *patch;
      sums_[i].images += 1;
    });
  }

  /// The direction of what the images show, without one that was added as this and with this weight; empty where too
  /// few do, or they contradict each other.
  std::optional<Patch> others(std::size_t number, const Patch& seen, float weight) const {
    const Sums& sums = sums_[number];
    if (sums.images - (weight > 0) < kLeastImages) return {};
    const Patch rest = sums.patch - weight * seen;
    const float norm = rest.matrix().norm();
    if (!(norm > 0)) return {};
    return rest / norm;
  }

 private:
  static std::vector<float> spacings(const std::vector<float>& footprints, double spacing_px) {
    std::vector<float> spacing;
    for (const float footprint : footprints) spacing.push_back(static_cast<float>(spacing_px) * footprint);
    return spacing;
  }

  struct Sums {
    Patch patch = Patch::Zero();
    int images = 0;
  };
  const Mesh& mesh_;
  VertexPatches patches_;
  RayScene scene_;
  std::vector<std::size_t> vertices_;
  std::vector<Sums> sums_;
};

/// A patch of an image, and what the others show there.
struct Target {
  Eigen::Vector3d vertex;
  PatchView seen;
  Patch others;
};

std::vector<Target> targets_of(const PatchConsensus& consensus, const GreyPyramid& image, const PosedCamera& view,
                               bool among_them) {
  std::vector<std::optional<Target>> found(consensus.size());
  tbb::parallel_for(std::size_t{0}, consensus.size(), [&](std::size_t i) {
    const auto seen = consensus.look(image, view, i);
    const auto patch = seen ? seen->sample(image, seen->pixel) : std::nullopt;
    if (!patch) return;
    const auto others = consensus.others(i, *patch, among_them ? seen->cosine : 0);
    if (others) found[i] = Target{consensus.vertex(i).cast<double>(), *seen, *others};
  });
  std::vector<Target> targets;
  for (std::optional<Target>& target : found)
    if (target) targets.push_back(*std::move(target));
  return targets;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

/// How pixels change with a small motion on the left of the pose: rotation vector (rad), translation (m).
Eigen::Matrix<double, 2, 6> pixel_from_motion(const Target& target, const Rigid3& given) {
  const Eigen::Vector3d p = given * target.vertex;
  const Eigen::Matrix<double, 2, 3> from_camera =
      target.seen.pixel_from_offset.cast<double>() * given.rotation.toRotationMatrix().transpose();
  Eigen::Matrix<double, 2, 6> motion;
  motion << -from_camera * cross_matrix(p), from_camera;
  return motion;
}

/// What one patch says of its place.
struct Shift {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d pull = Eigen::Vector2d::Zero();
  double squares = -1;  ///< of what it is off by, of its own norm; below 0: it says nothing
};

Shift shift_of(const Target& target, const GreyPyramid& image, const Eigen::Vector2d& moved) {
  Shift shift;
  const Eigen::Vector2f at = target.seen.pixel + moved.cast<float>();
  const auto here = target.seen.sample(image, at);
  if (!here) return shift;
  const float norm = here->matrix().norm();
  if (!(here->matrix().dot(target.others.matrix()) > kLeastAgreement * norm)) return shift;
  const float step = kDifference * static_cast<float>(1 << target.seen.level);
  Eigen::Matrix<float, kPatchPoints, 2> gradient;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2f aside = step * Eigen::Vector2f::Unit(axis);
    const auto after = target.seen.sample(image, at + aside), before = target.seen.sample(image, at - aside);
    if (!after || !before) return shift;
    gradient.col(axis) = (*after - *before) / (2 * step);
  }
  const Eigen::Matrix<float, kPatchPoints, 1> off = norm * target.others - *here;
  shift.information = (gradient.transpose() * gradient).cast<double>();
  shift.pull = (gradient.transpose() * off).cast<double>();
  shift.squares = off.squaredNorm();
  return shift;
}

/// A small motion on the left of a pose.
Rigid3 moved_by(const Vector6& motion, const Rigid3& pose) {
  const Eigen::Vector3d w = motion.head<3>();
  const double angle = w.norm();
  const Rigid3 by{angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, w / angle)) : Eigen::Quaterniond::Identity(),
                  motion.tail<3>()};
  return by * pose;
}

/// A motion on the left of a pose, and how well it is known.
struct MotionFit {
  Vector6 motion = Vector6::Zero();
  Matrix6 covariance = Matrix6::Zero();
  Matrix6 spread = Matrix6::Zero();  ///< by how much it moves the surface in the image: mean squared pixels
  std::size_t patches = 0;           ///< that it rests on; 0: there is none
};

/// The motion with which an image shows of the patches what the others do: robust least squares over their shifts,
/// within what a pose as it was given may be off by.
MotionFit fit_motion(std::span<const Target> targets, double overlap, const GreyPyramid& image, const Rigid3& from) {
  MotionFit fit;
  if (targets.size() < kLeastPatches) return {};
  std::vector<Eigen::Matrix<double, 2, 6>> motions;
  for (const Target& target : targets) {
    motions.push_back(pixel_from_motion(target, from));
    fit.spread += motions.back().transpose() * motions.back() / static_cast<double>(targets.size());
  }
  const Matrix6 given = fit.spread / (kGivenSigma_px * kGivenSigma_px);
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Shift> shifts(targets.size());
    tbb::parallel_for(std::size_t{0}, targets.size(),
                      [&](std::size_t i) { shifts[i] = shift_of(targets[i], image, motions[i] * fit.motion); });
    std::vector<double> squares;
    for (const Shift& shift : shifts)
      if (shift.squares >= 0) squares.push_back(shift.squares);
    if (squares.size() < kLeastPatches) return {};
    const double usual = std::max(median(squares), 1e-6);
    const double variance = overlap * usual / kPatchPoints;  // of a value of a patch
    Matrix6 information = given;
    Vector6 pull = -given * fit.motion;
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      if (shifts[i].squares < 0) continue;
      const double weight = 1 / (1 + shifts[i].squares / usual) / variance;  // Cauchy's
      information += weight * motions[i].transpose() * shifts[i].information * motions[i];
      pull += weight * motions[i].transpose() * shifts[i].pull;
    }
    const Eigen::LDLT<Matrix6> solver(information);
    fit.motion += solver.solve(pull);
    fit.covariance = solver.solve(Matrix6::Identity());
    fit.patches = squares.size();
  }
  return fit.motion.allFinite() ? fit : MotionFit{};
}

/// By how much two halves of the surface, on either side of its middle in the image, contradict each other: the squared
/// difference of their motions over its variance, in the mean 1; empty where one of them says nothing.
std::optional<double> contradiction(std::vector<Target> targets, double overlap, const GreyPyramid& image,
                                    const Rigid3& from) {
  const auto middle = targets.begin() + static_cast<std::ptrdiff_t>(targets.size() / 2);
  std::nth_element(targets.begin(), middle, targets.end(),
                   [](const Target& a, const Target& b) { return a.seen.pixel.x() < b.seen.pixel.x(); });
  const MotionFit first = fit_motion({targets.begin(), middle}, overlap, image, from);
  const MotionFit second = fit_motion({middle, targets.end()}, overlap, image, from);
  if (first.patches == 0 || second.patches == 0) return {};
  const Vector6 difference = first.motion - second.motion;
  return difference.dot((first.covariance + second.covariance).ldlt().solve(difference)) / 6;
}

/// How far two poses bring the surface apart in the image, pixels, root of the mean square over the targets.
double apart_px(const std::vector<Target>& targets, const Camera& camera, const Rigid3& a, const Rigid3& b) {
  double squares = 0;
  std::size_t count = 0;
  for (const Target& target : targets) {
    const auto in_a = camera.project(a * target.vertex), in_b = camera.project(b * target.vertex);
    if (!in_a || !in_b) continue;
    squares += (*in_a - *in_b).squaredNorm();
    ++count;
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
}

}  // namespace

std::vector<RefinedPose> refine_poses(const Mesh& mesh, const RefinementImages& images,
                                      const std::vector<std::size_t>& leaders, const std::vector<std::size_t>& movers,
                                      const StepsDone& progress) {
  if (leaders.size() < kLeastImages) throw Error("refining poses needs two images or more that are not held out");
  const MeshEdges edges(mesh);
  const std::vector<float> footprints = pixel_footprints(mesh, images.cameras);
  std::vector<PosedCamera> views = images.cameras;
  std::vector<RefinedPose> refined;
  for (const PosedCamera& view : views) refined.push_back({.camera_from_object = view.camera_from_object});
  std::vector<bool> leads(views.size(), false);
  for (const std::size_t i : leaders) leads[i] = true;
  std::size_t done = 0;
  const auto step_done = [&] {
    if (progress) progress(++done, kSpacings_px.size() * (leaders.size() + movers.size()));
  };
  std::vector<double> contradictions;  // of halves of an image, in squared standard deviations
  for (std::size_t pass = 0; pass < kSpacings_px.size(); ++pass) {
    const bool last = pass + 1 == kSpacings_px.size();
    PatchConsensus consensus(mesh, edges, footprints, kSpacings_px[pass]);
    const double overlap = consensus.overlap();
    for (const std::size_t i : leaders) {
      consensus.add(GreyPyramid(images.read(i)), views[i]);
      step_done();
    }
    // Each is moved to what the others showed before any of them moved.
    for (const std::size_t i : movers) {
      const GreyPyramid image(images.read(i));
      const std::vector<Target> targets = targets_of(consensus, image, views[i], leads[i]);
      const Rigid3& from = views[i].camera_from_object;
      const MotionFit fit = fit_motion(targets, overlap, image, from);
      const Rigid3 to = moved_by(fit.motion, from);
      refined[i] = {.camera_from_object = to,
                    .moved_px = apart_px(targets, views[i].camera, images.cameras[i].camera_from_object, to),
                    .uncertainty_px = std::sqrt((fit.covariance * fit.spread).trace()),
                    .patches = fit.patches};
      if (const auto squared = last ? contradiction(targets, overlap, image, to) : std::nullopt)
        contradictions.push_back(*squared);
      step_done();
    }
    for (const std::size_t i : movers) views[i].camera_from_object = refined[i].camera_from_object;
  }
  // What a whole side gets wrong (reflections, a mesh that is off) is not in what a fit says of itself.
  const double overconfidence =
      contradictions.empty() ? 1 : std::sqrt(std::max(1.0, median(contradictions) / kMedianOfContradiction));
  for (const std::size_t i : movers)
    refined[i].uncertainty_px = std::hypot(overconfidence * refined[i].uncertainty_px, kCommonError_px);
  return refined;
}

}  // namespace sheen
