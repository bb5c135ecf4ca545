// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "reconstructor/light_field_file/mesh_coding.h"

namespace sheen {

/// Cameras halved again and again by where they stand, and the unbalanced Haar transform of what varies over some of
/// them: what lies near each other is alike, so most of its coefficients are small. Orthonormal for every subset. How
/// they are halved is decided in whole numbers. The paper's view maps (000 sec. 4.2) play no part.
class ViewHaar {
 public:
  /// `eyes`: where the cameras stand; `centre`: of the object.
  ViewHaar(const std::vector<GridMesh::Point>& eyes, const GridMesh::Point& centre);

  /// A subset of the cameras, ready to be transformed.
  struct Plan {
    struct Step {
      Eigen::Index into, from;  ///< places whose means are joined into the first
      double weight_into, weight_from;
      Eigen::Index coefficient;  ///< where the difference goes
      Eigen::Index parent;       ///< coefficient of the join that comes after
    };
    std::vector<Step> steps;  ///< from the leaves to the root
    Eigen::Index size = 0;
  };
  /// `images`: ascending.
  Plan plan(const std::vector<std::uint16_t>& images) const;

  /// Rows are transformed by themselves: values over the images into coefficients, the mean first, then differences
  /// from the coarsest to the finest.
  static void forward(const Plan& plan, Eigen::Ref<Eigen::VectorXf> values);
  static void inverse(const Plan& plan, Eigen::Ref<Eigen::VectorXf> coefficients);

 private:
  struct Node {
    int low = -1, high = -1;  ///< children; a leaf has none
    std::uint16_t image = 0;
    int depth = 0;
  };
  std::vector<Node> nodes_;
  using Direction = std::array<std::int64_t, 3>;
  int halve(std::vector<std::uint16_t>& images, std::size_t first, std::size_t last,
            const std::vector<Direction>& directions, int depth);
};

}  // namespace sheen
