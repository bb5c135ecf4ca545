// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/depth_fusion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace sheen {
namespace {

constexpr double kReach = 3.5;              // cells to either side of a surface in which its view counts
constexpr float kHullWeight = 0.02f;        // a view that sees a surface straight and surely has 1
constexpr float kBackgroundWeight = 0.03f;  // of a view that shows background at a point, and no surface
// A little way behind what a view sees is likely to be inside, in a hull that is sure: else one wrong depth, as of a
// highlight, which lies deeper, would bore a hole.
constexpr float kBehind = 3;  // reaches
constexpr float kBehindWeight = 0.6f;
constexpr float kOverrulesHull = 0.7f;
// A hull that is sure cuts what depths say before it. As depths err to both sides, the mean of what is left would lie
// behind the surface. So they count by how much more than such an error they say; far behind the hull, in full.
constexpr double kDepthError = 1;      // cells
constexpr double kBehindSureHull = 4;  // cells, from where they count in full
constexpr double kThickness = 0.15;  // of the box's diagonal: so deep behind what is seen the object is taken to reach
constexpr int kFewestBefore = 2;
constexpr int kFewestOutlines = 3;  // that tell of a point: else the hull is there because hardly any view shows it
constexpr int kSmoothings = 20;
constexpr float kSmoothness = 0.5f;  // weight of a point's six neighbours, where a view has 1
constexpr float kMostWeight = 5;
constexpr int kSide = BlockField::kSide;

/// A view, ready to be asked about points.
struct DepthView {
  Eigen::Matrix<float, 3, 4> view_from_centred;
  float fx, fy, cx, cy;
  const DepthMap* map;
  const ImageU8* outline;
};

std::vector<DepthView> depth_views(std::span<const ShapeView> views, std::span<const DepthMap> depths,
                                   const Eigen::Vector3d& centre) {
  std::vector<DepthView> out;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera.camera;
    const Rigid3& pose = views[i].camera.camera_from_object;
    Eigen::Matrix<double, 3, 4> from_centred;
    from_centred.leftCols<3>() = pose.rotation.toRotationMatrix();
    from_centred.col(3) = pose * centre;
    out.push_back({from_centred.cast<float>(), static_cast<float>(camera.fx), static_cast<float>(camera.fy),
                   static_cast<float>(camera.cx), static_cast<float>(camera.cy), &depths[i], &views[i].outline});
  }
  return out;
}

/// What a view that has a point in its frame says of it; of no weight where it knows neither surface nor background.
struct Said {
  float off = 0;  ///< how far the point lies before the surface, square to it, metres; negative behind
  float weight = 0;
};

/// Empty where the point is not in its frame. `far`: how far the background lies behind.
std::optional<Said> said_by(const DepthView& view, const Eigen::Vector3f& centred, float far) {
  const Eigen::Vector3f p = view.view_from_centred * centred.homogeneous();
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector3f ray(p.x() / p.z(), p.y() / p.z(), 1);
  const float u = view.fx * ray.x() + view.cx + 0.5f, v = view.fy * ray.y() + view.cy + 0.5f;
  const ImageF& depth = view.map->depth;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(depth.width()) && v < static_cast<float>(depth.height())))
    return std::nullopt;
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float known = depth.at(x, y);
  if (!(known > 0)) {
    if (view.outline->empty() || view.outline->at(x, y) != static_cast<std::uint8_t>(Outline::kBackground))
      return Said{};
    return Said{.off = far, .weight = kBackgroundWeight};
  }
  const Eigen::Map<const Eigen::Vector3f> normal(view.map->normal.pixel(x, y));
  const Eigen::Vector3f pixel_ray((static_cast<float>(x) - view.cx) / view.fx,
                                  (static_cast<float>(y) - view.cy) / view.fy, 1);
  const float along = normal.dot(ray), cosine = -along / ray.norm();
  if (!(cosine > 0.05f)) return Said{};
  const float here = known * normal.dot(pixel_ray) / along;  // of the pixel's plane, on the point's ray
  return Said{.off = (here - p.z()) * -along, .weight = cosine * std::max(0.0f, 1 - view.map->cost.at(x, y))};
}

class Fusion {
 public:
  Fusion(std::vector<DepthView> views, const VisualHull& hull, bool hull_is_sure, double cell)
      : views_(std::move(views)),
        hull_(hull),
        hull_is_sure_(hull_is_sure),
        thickness_(static_cast<float>(kThickness * hull.box().diagonal().norm())),
        reach_(static_cast<float>(kReach * cell)),
        depth_error_(static_cast<float>(kDepthError * cell)) {}

  struct Value {
    float distance = 0, weight = 0;
  };
  Value at(const Eigen::Vector3d& point) const {
    const auto [hull, outlines] = hull_.at(point);
    const bool bounded_here = outlines >= kFewestOutlines, sure = hull_is_sure_ && bounded_here;
    if (hull_is_sure_ && hull > reach_) return {reach_, kMostWeight};
    const Eigen::Vector3f centred = (point - hull_.box().center()).cast<float>();
    float sum = 0, weight = 0;
    int asked = 0, behind = 0;
    for (const DepthView& view : views_) {
      const std::optional<Said> said = said_by(view, centred, reach_);
      if (!said) continue;
      ++asked;
      if (said->weight > 0 && said->off < 0 && said->off > -thickness_) ++behind;
      if (said->off < -(sure ? kBehind : 1) * reach_) continue;
      const float counted = said->off < -reach_ ? kBehindWeight * said->weight : said->weight;
      sum += counted * std::clamp(said->off, -reach_, reach_);
      weight += counted;
    }
    const float hull_off = std::clamp(hull, -reach_, reach_);
    const bool bodily = bounded_here || behind >= std::max(kFewestBefore, asked / 2);
    const float mean =
        -(sure ? error_near(hull) : 0) + (sum + kHullWeight * (bodily ? hull_off : reach_)) / (weight + kHullWeight);
    const bool bounded = sure || weight <= kOverrulesHull;
    return {bounded ? std::max(mean, hull_off) : mean, std::min(kMostWeight, weight + kHullWeight)};
  }
  float reach() const { return reach_; }

 private:
  /// By how much depths must say more than a hull that is sure to count, at a distance from it.
  float error_near(float hull) const {
    constexpr auto kFull = static_cast<float>(kBehindSureHull / kDepthError);
    return std::max(0.0f, depth_error_ - std::abs(hull) / kFull);
  }

  std::vector<DepthView> views_;
  const VisualHull& hull_;
  bool hull_is_sure_;
  float thickness_, reach_, depth_error_;
};

using Blocks = std::vector<std::uint8_t>;

/// Marks the blocks that surfaces of the views pass through.
void mark_surfaces(std::span<const ShapeView> views, std::span<const DepthMap> depths, const BlockField& field,
                   float reach, Blocks& marked) {
  const Lattice& lattice = field.lattice();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Rigid3 object_from_view = views[i].camera.camera_from_object.inverse();
    const Camera& camera = views[i].camera.camera;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const double depth = depths[i].depth.at(x, y);
        if (!(depth > 0)) continue;
        const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
        for (const double off : {-reach, 0.0f, reach}) {
          const Eigen::Vector3d point = object_from_view * (ray * (depth + off / ray.norm()));
          const Eigen::Array3i block = ((point - lattice.origin).array() / (kSide * lattice.cell)).floor().cast<int>();
          if ((block >= 0).all() && (block < field.blocks()).all())
            marked[block.x() + field.blocks().x() * (block.y() + std::size_t(field.blocks().y()) * block.z())] = 1;
        }
      }
  }
}

/// Draws each point towards its neighbours as far as what is known of it allows.
void smooth(BlockField& field, const std::vector<float>& weights, const ForEach& for_each) {
  const std::size_t count = field.stored();
  std::vector<float> measured(count * BlockField::kBlockPoints), next(measured.size());
  for (std::size_t b = 0; b < count; ++b)
    std::copy_n(field.values(field.stored_blocks()[b]), BlockField::kBlockPoints,
                measured.data() + b * BlockField::kBlockPoints);
  for (int round = 0; round < kSmoothings; ++round) {
    for_each(count, [&](std::size_t b) {
      const Eigen::Array3i block = field.stored_blocks()[b];
      const float* own = field.values(block);
      for (int i = 0; i < BlockField::kBlockPoints; ++i) {
        const Eigen::Array3i place(i % kSide, i / kSide % kSide, i / (kSide * kSide));
        float sum = 0;
        int known = 0;
        for (int axis = 0; axis < 3; ++axis)
          for (const int step : {-1, 1}) {
            Eigen::Array3i beside = place;
            beside[axis] += step;
            float value;
            if (beside[axis] >= 0 && beside[axis] < kSide) {
              value = own[BlockField::number_in_block(beside)];
            } else {
              const Eigen::Array3i point = kSide * block + beside;
              if (point[axis] < 0 || point[axis] >= field.lattice().points[axis]) continue;
              value = field.at(point);
              if (std::abs(value) >= BlockField::kFar) continue;
            }
            sum += value;
            ++known;
          }
        const std::size_t n = b * BlockField::kBlockPoints + i;
        next[n] = known == 0 ? own[i]
                             : (weights[n] * measured[n] + kSmoothness * sum / static_cast<float>(known)) /
                                   (weights[n] + kSmoothness);
      }
    });
    for_each(count, [&](std::size_t b) {
      std::copy_n(next.data() + b * BlockField::kBlockPoints, BlockField::kBlockPoints,
                  field.values(field.stored_blocks()[b]));
    });
  }
}

}  // namespace

BlockField fused_surface(std::span<const ShapeView> views, std::span<const DepthMap> depths, const VisualHull& hull,
                         bool hull_is_sure, const Lattice& lattice, const ForEach& for_each) {
  const Fusion fusion(depth_views(views, depths, hull.box().center()), hull, hull_is_sure, lattice.cell);
  BlockField field(lattice);
  const Eigen::Array3i blocks = field.blocks();
  const auto block_number = [&](std::size_t i) {
    const int n = static_cast<int>(i);
    return Eigen::Array3i(n % blocks.x(), n / blocks.x() % blocks.y(), n / (blocks.x() * blocks.y()));
  };
  Blocks marked(blocks.prod(), 0), inside(marked.size(), 0);
  mark_surfaces(views, depths, field, fusion.reach(), marked);
  for_each(marked.size(), [&](std::size_t i) {
    const Eigen::Array3d middle = (kSide * block_number(i)).cast<double>() + 0.5 * (kSide - 1);
    inside[i] = fusion.at(lattice.origin + lattice.cell * middle.matrix()).distance < 0 ? 1 : 0;
  });
  // Where a block that is inside meets one that is outside, both are looked at point by point.
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const Eigen::Array3i block = block_number(i);
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Array3i beside = block;
      if (++beside[axis] >= blocks[axis]) continue;
      const std::size_t j = beside.x() + blocks.x() * (beside.y() + std::size_t(blocks.y()) * beside.z());
      if (inside[i] != inside[j]) marked[i] = marked[j] = 1;
    }
  }
  for (std::size_t i = 0; i < marked.size(); ++i) {
    field.fill(block_number(i), inside[i] != 0);
    if (marked[i] != 0) field.store(block_number(i));
  }
  std::vector<float> weights(field.stored() * BlockField::kBlockPoints);
  for_each(field.stored(), [&](std::size_t b) {
    const Eigen::Array3i block = field.stored_blocks()[b];
    float* values = field.values(block);
    for (int i = 0; i < BlockField::kBlockPoints; ++i) {
      const Eigen::Array3i place(i % kSide, i / kSide % kSide, i / (kSide * kSide));
      const Fusion::Value value = fusion.at(lattice.at(kSide * block + place));
      values[i] = value.distance;
      weights[b * BlockField::kBlockPoints + i] = value.weight;
    }
  });
  smooth(field, weights, for_each);
  return field;
}

int views_of(const Eigen::Vector3d& point, std::span<const ShapeView> views, std::span<const DepthMap> depths,
             double reach) {
  int seeing = 0;
  for (const DepthView& view : depth_views(views, depths, point)) {
    const std::optional<Said> said = said_by(view, Eigen::Vector3f::Zero(), BlockField::kFar);
    if (said && said->weight > 0 && std::abs(said->off) <= static_cast<float>(reach)) ++seeing;
  }
  return seeing;
}

}  // namespace sheen
