// SPDX-License-Identifier: Apache-2.0
#include "common/registration/frame_mistakes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/angle.h"
#include "common/base/format.h"
#include "common/registration/outline_evidence.h"
#include "common/registration/silhouette.h"
#include "common/registration/texture_evidence.h"

namespace sheen {
namespace {

constexpr int kMaskWidth_px = 200;         // of the images that silhouettes are compared with masks in
constexpr double kMaskOfAll = 0.9;         // of the image: such a mask does not say where the object is
constexpr double kOverlaps = 0.7;          // of silhouette and mask, over their union: the mesh stands there
constexpr double kOverlapsBetter = 0.1;    // more of it than where the mesh stands
constexpr double kTextureAsOverlap = 0.1;  // what a correlation of 1 decides between outlines that fit alike
constexpr double kAgrees = 0.25, kAgreesBetter = 0.12;  // the same of the texture's correlation
constexpr int kFinestLevel = 1, kWidth_levels = 2;      // a coarse look is at a mesh of four times the narrowest width
constexpr std::size_t kFewPoints = 200;                 // about which images agree: fewer say nothing
constexpr std::size_t kLookedAtAgain = 6;
constexpr double kInView = 0.7;  // of the cameras
constexpr double kMargin_px = 2;
constexpr double kSamePlace = 0.02;  // of the mesh's radius

std::string axis_words(const Eigen::RowVector3d& row) {
  constexpr std::array kNames{"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(row[axis]) > 0.5) return std::string(row[axis] < 0 ? "-" : "") + kNames[axis];
  return "0";
}

/// Of a matrix that swaps and negates axes.
std::string axes_words(const Eigen::Matrix3d& matrix) {
  return "(x, y, z) becomes (" + axis_words(matrix.row(0)) + ", " + axis_words(matrix.row(1)) + ", " +
         axis_words(matrix.row(2)) + ")";
}

std::string turn_words(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  const int degrees = static_cast<int>(std::lround(turn.angle() / kDegree));
  int along = 0;
  if (turn.axis().cwiseAbs().maxCoeff(&along) < 0.99) return "swap its axes";
  const int sign = turn.axis()[along] < 0 && degrees != 180 ? -1 : 1;
  return format("turn it by %d degrees about %c%s", sign * degrees, "xyz"[along],
                along == 0 && degrees == 90 ? " (one of y and z was up in another program)" : "");
}

/// All that take axes to axes and keep the handedness, the identity first.
std::vector<Eigen::Matrix3d> right_angles() {
  std::vector<Eigen::Matrix3d> turns;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) turn(row, order[row]) = signs & (1 << row) ? -1 : 1;
      if (turn.determinant() > 0) turns.push_back(turn);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return turns;
}

Similarity inverse_of(const Similarity& similarity) {
  Similarity inverse;
  inverse.scale = 1 / similarity.scale;
  inverse.rotation = similarity.rotation.transpose();
  inverse.translation = -(inverse.scale * (inverse.rotation * similarity.translation));
  return inverse;
}

Mesh mirrored(Mesh mesh) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex.x() = -vertex.x();
  mesh.origin.x() = -mesh.origin.x();
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

/// Pixels of a mask that says where the object is, some 200 wide; empty where it does not.
ImageU8 small_mask(const ImageU8& mask, const Camera& small) {
  ImageU8 shrunk(small.width, small.height, 1, 0);
  std::size_t object = 0;
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      shrunk.at(x, y) =
          mask.at((2 * x + 1) * mask.width() / (2 * small.width), (2 * y + 1) * mask.height() / (2 * small.height));
      object += shrunk.at(x, y) != 0;
    }
  if (static_cast<double>(object) > kMaskOfAll * static_cast<double>(shrunk.size())) object = 0;
  if (object == 0) return {};
  return shrunk;
}

struct MaskedView {
  PosedCamera view;
  ImageU8 mask;
};

std::vector<MaskedView> masked_views(std::span<const RegistrationImage> images) {
  std::vector<MaskedView> views;
  for (const RegistrationImage& image : images) {
    if (image.mask.empty()) continue;
    const Camera& full = image.view.camera;
    const int width = std::min(kMaskWidth_px, full.width);
    const PosedCamera view{full.scaled(width, std::max(1, full.height * width / full.width)),
                           image.view.camera_from_object};
    ImageU8 mask = small_mask(image.mask, view.camera);
    if (!mask.empty()) views.push_back({view, std::move(mask)});
  }
  return views;
}

/// The point nearest to the rays through the middles of the masks.
std::optional<Eigen::Vector3d> middle_of(const std::vector<MaskedView>& views) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const MaskedView& masked : views) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double pixels = 0;
    for (int y = 0; y < masked.mask.height(); ++y)
      for (int x = 0; x < masked.mask.width(); ++x)
        if (masked.mask.at(x, y) != 0) sum += Eigen::Vector2d(x, y), ++pixels;
    const auto ray = masked.view.camera.ray(sum / pixels);
    if (!ray) continue;
    const Rigid3 object_from_camera = masked.view.camera_from_object.inverse();
    const Eigen::Vector3d along = (object_from_camera.rotation * *ray).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
    normal += across;
    right += across * object_from_camera.translation;
  }
  if (views.size() < 2 || normal.determinant() < 1e-6) return {};
  return normal.ldlt().solve(right);
}

/// Whether most cameras have the middle of the mesh before them and in their image.
bool in_view(const BoundingSphere& sphere, const Similarity& place, std::span<const RegistrationImage> images) {
  const Eigen::Vector3d middle = place * sphere.centre;
  const auto seen = std::count_if(images.begin(), images.end(), [&](const RegistrationImage& image) {
    const Eigen::Vector3d at = image.view.camera_from_object * middle;
    const auto pixel = image.view.camera.project(at);
    return pixel && at.norm() > place.scale * sphere.radius && image.view.camera.contains(*pixel, 0);
  });
  return static_cast<double>(seen) >= kInView * static_cast<double>(images.size());
}

/// Where a mesh of either handedness fits best.
class FrameSearch {
 public:
  /// `origin`: of the images' frame, in that of the mesh's file.
  FrameSearch(const Mesh& mesh, const Eigen::Vector3d& origin, std::span<const RegistrationImage> images,
              const std::vector<MaskedView>& masks)
      : mesh_(mesh),
        origin_(origin),
        scene_(mesh),
        sphere_(bounding_sphere(mesh)),
        images_(images),
        masks_(masks),
        texture_(mesh, scene_, images, kFinestLevel) {}

  std::vector<FrameMistake> candidates(const std::optional<Similarity>& applied, bool is_mirrored) const;

  /// How well a place fits: what masks and silhouettes have in common, or how the images agree; 0 where nothing is
  /// seen.
  double fit(const Similarity& place, bool coarse) {
    if (masks_.empty()) return agreement(place, coarse);
    const double overlap = overlap_at(place);
    return overlap < kOverlaps ? overlap : overlap + kTextureAsOverlap * agreement(place, coarse);
  }

  /// The candidates that fit best at a coarse look, then what fits best of these.
  std::optional<std::pair<FrameMistake, double>> best_of(const std::vector<FrameMistake>& candidates) {
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Similarity& place = candidates[i].poses_from_mesh;
      if (in_view(sphere_, place, images_)) ranked.emplace_back(-fit(place, true), i);
    }
    std::sort(ranked.begin(), ranked.end());
    if (ranked.size() > kLookedAtAgain) ranked.resize(kLookedAtAgain);
    std::optional<std::pair<FrameMistake, double>> best;
    for (const auto& [unused, i] : ranked) {
      const double found = fit(candidates[i].poses_from_mesh, false);
      if (!best || found > best->second) best = {candidates[i], found};
    }
    return best;
  }

 private:
  double agreement(const Similarity& place, bool coarse) {
    const int level = coarse ? std::max(kFinestLevel, texture_.coarsest(place) - kWidth_levels) : kFinestLevel;
    texture_.see(place, level, kMargin_px);
    const TextureEvidence::Agreement found = texture_.agreement(place);
    return found.points < kFewPoints ? 0 : found.correlation;
  }

  double overlap_at(const Similarity& place) {
    double sum = 0;
    for (const MaskedView& masked : masks_) {
      const ImageU8 shown = caster_.cast(in_mesh_frame(masked.view, place), mesh_, scene_);
      double both = 0, either = 0;
      for (std::size_t i = 0; i < shown.size(); ++i) {
        const bool in_mesh = shown.data()[i] != 0, in_mask = masked.mask.data()[i] != 0;
        both += in_mesh && in_mask;
        either += in_mesh || in_mask;
      }
      sum += both / std::max(either, 1.0);
    }
    return sum / static_cast<double>(masks_.size());
  }

  /// What is told of points of the file, told of those of the mesh and the images.
  Similarity from_file(Similarity place) const {
    place.translation = place * mesh_.origin - origin_;
    return place;
  }

  const Mesh& mesh_;
  const Eigen::Vector3d origin_;
  const RayScene scene_;
  const BoundingSphere sphere_;
  std::span<const RegistrationImage> images_;
  const std::vector<MaskedView>& masks_;
  TextureEvidence texture_;
  SilhouetteCaster caster_;
};

std::vector<FrameMistake> FrameSearch::candidates(const std::optional<Similarity>& applied, bool is_mirrored) const {
  std::vector<FrameMistake> all;
  if (applied && !is_mirrored) {
    all.push_back(
        {"it is in the frame that the poses had before `applied_transform`: apply `applied_transform` to it, "
         "or its inverse to the poses",
         from_file(*applied)});
    all.push_back(
        {"apply the inverse of `applied_transform` to it: it was applied twice", from_file(inverse_of(*applied))});
  }
  const std::optional<Eigen::Vector3d> object = middle_of(masks_);
  const double same = kSamePlace * sphere_.radius;
  Eigen::Matrix3d handedness = Eigen::Matrix3d::Identity();
  if (is_mirrored) handedness(0, 0) = -1;
  for (const Eigen::Matrix3d& turn : right_angles()) {
    const bool turned = !turn.isIdentity();
    std::string words = is_mirrored ? "mirror it" : turned ? turn_words(turn) : "";
    if (is_mirrored || turned) words += ", so that " + axes_words(turn * handedness);
    const auto then = [&words](const std::string& move) { return words.empty() ? move : words + ", and " + move; };
    Similarity about_origin;
    about_origin.rotation = turn;
    about_origin = from_file(about_origin);
    if (is_mirrored || turned) all.push_back({words, about_origin, is_mirrored});
    const auto moved_to = [&](const Eigen::Vector3d& middle, const std::string& how) {
      Similarity place = about_origin;
      place.translation = middle - turn * sphere_.centre;
      if ((place.translation - about_origin.translation).norm() > same) all.push_back({then(how), place, is_mirrored});
    };
    Eigen::Vector3d middle = sphere_.centre + mesh_.origin;
    if (is_mirrored) middle.x() = -middle.x();  // where it stands in the file
    middle -= origin_;
    if (is_mirrored || turned) moved_to(middle, "its middle stays where it is");
    if (object) {
      const Eigen::Vector3d there = *object + origin_;
      moved_to(*object, format("move its middle to about (%.4f, %.4f, %.4f)", there.x(), there.y(), there.z()));
    }
  }
  if (is_mirrored) return all;
  for (const double scale : {1e-3, 1e-2, 0.0254, 0.1, 10.0, 1 / 0.0254, 100.0, 1000.0}) {
    Similarity place;
    place.scale = scale;
    all.push_back({format("scale it by %.4g: it is in another unit than the poses", scale), from_file(place)});
  }
  return all;
}

}  // namespace

std::string in_words(const FrameMistake& mistake) {
  return "it fits once its frame is corrected: " + mistake.remedy;
}

std::optional<FrameMistake> find_frame_mistake(const Mesh& mesh, std::span<const RegistrationImage> images,
                                               const std::optional<Similarity>& applied) {
  const std::vector<MaskedView> masks = masked_views(images);
  const double least = masks.empty() ? kAgrees : kOverlaps, better = masks.empty() ? kAgreesBetter : kOverlapsBetter;
  double here = 0;
  for (const bool is_mirrored : {false, true}) {
    const Mesh tried = is_mirrored ? mirrored(mesh) : mesh;
    FrameSearch search(tried, mesh.origin, images, masks);
    if (!is_mirrored) here = search.fit(Similarity{}, false);
    const auto best = search.best_of(search.candidates(applied, is_mirrored));
    if (best && best->second > least && best->second > here + better) return best->first;
  }
  return {};
}

}  // namespace sheen
