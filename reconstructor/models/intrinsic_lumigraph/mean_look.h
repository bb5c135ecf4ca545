// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/lumigraph_file/lumigraph_data.h"
#include "reconstructor/surface/sample_state.h"

namespace sheen {

/// Colours of a surface point where a lamp's light arrives and where it does not, linear.
struct LitAndDark {
  Eigen::Vector3f lit = Eigen::Vector3f::Zero(), dark = Eigen::Vector3f::Zero();
};

/// How the outside of a mesh looks to all views together: matt, per vertex the mean over the views that show it. It is
/// what is safely known where no view is near.
class MeanLook {
  /// A matt surface: its radiance is `ambient`, and where light arrives `slope` * incidence more.
  struct Matt {
    Eigen::Vector3f ambient = Eigen::Vector3f::Zero();
    Eigen::Matrix3f slope = Eigen::Matrix3f::Zero();  ///< a row a colour
    float weight = 0;                                 ///< of what was added up
    void add(const IntrinsicView& view, std::size_t pixel, float weight);
    Matt& operator+=(const Matt& other);
    Matt mean() const;
    Eigen::Vector3f added_by(const Eigen::Vector3f& incidence) const { return (slope * incidence).cwiseMax(0.0f); }
  };

 public:
  MeanLook(std::shared_ptr<const Mesh> mesh, const LumigraphData& data);

  std::size_t bytes() const { return looks_.size() * sizeof(Matt); }

  /// In one light.
  class Lit {
   public:
    struct Sample : LitAndDark {
      SampleState state = SampleState::kUnseen;  ///< imputed where views show the vertices
    };
    /// At barycentric (u, v) of a triangle.
    Sample at(std::uint32_t triangle, float u, float v) const;

   private:
    friend class MeanLook;
    std::shared_ptr<const Mesh> mesh_;
    std::shared_ptr<const std::vector<std::uint8_t>> seen_;
    std::vector<LitAndDark> colours_;  ///< per vertex
  };
  Lit in(const Lamp& lamp, const Eigen::Vector3f& rgb) const;
  /// In the mean of the lights, wherever they arrive; both colours are the same.
  Lit in_all(const LightSet& lights) const;

 private:
  static Matt seen_of(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, const LumigraphData& data);
  static Matt mean_of(const LumigraphData& data);
  Lit lit(std::vector<LitAndDark> colours) const;

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const std::vector<std::uint8_t>> seen_;  ///< per vertex: some view shows it
  std::vector<Matt> looks_;                                ///< per vertex
};

}  // namespace sheen
