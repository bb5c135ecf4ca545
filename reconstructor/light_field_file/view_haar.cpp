// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/view_haar.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstructor/light_field_file/grid_geometry.h"

namespace sheen {

ViewHaar::ViewHaar(const std::vector<GridMesh::Point>& eyes, const GridMesh::Point& centre) {
  std::vector<Direction> directions;
  directions.reserve(eyes.size());
  for (const GridMesh::Point& eye : eyes) directions.push_back(grid_direction(centre, eye));
  std::vector<std::uint16_t> images(eyes.size());
  std::iota(images.begin(), images.end(), std::uint16_t{0});
  if (!images.empty()) halve(images, 0, images.size(), directions, 0);
}

/// Along the axis along which they differ most, at the median. Children come behind their parents.
int ViewHaar::halve(std::vector<std::uint16_t>& images, std::size_t first, std::size_t last,
                    const std::vector<Direction>& directions, int depth) {
  const int node = static_cast<int>(nodes_.size());
  nodes_.push_back({.image = images[first], .depth = depth});
  if (last - first == 1) return node;
  Direction low = directions[images[first]], high = low;
  for (std::size_t i = first; i < last; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], directions[images[i]][k]);
      high[k] = std::max(high[k], directions[images[i]][k]);
    }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  const auto begin = images.begin() + static_cast<std::ptrdiff_t>(first),
             end = images.begin() + static_cast<std::ptrdiff_t>(last);
  std::sort(begin, end, [&](std::uint16_t a, std::uint16_t b) {
    return std::pair(directions[a][axis], a) < std::pair(directions[b][axis], b);
  });
  const std::size_t middle = (first + last) / 2;
  const int lower = halve(images, first, middle, directions, depth + 1);
  const int upper = halve(images, middle, last, directions, depth + 1);
  nodes_[static_cast<std::size_t>(node)].low = lower;
  nodes_[static_cast<std::size_t>(node)].high = upper;
  return node;
}

ViewHaar::Plan ViewHaar::plan(const std::vector<std::uint16_t>& images) const {
  Plan plan;
  plan.size = static_cast<Eigen::Index>(images.size());
  struct Group {
    Eigen::Index place = -1;  ///< of its mean; -1: none of the images is below
    double count = 0;
    int step = -1;  ///< that made it
  };
  std::vector<Group> groups(nodes_.size());
  std::vector<int> depths;
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // children first
    const Node& node = nodes_[n];
    if (node.low < 0) {
      const auto found = std::lower_bound(images.begin(), images.end(), node.image);
      if (found != images.end() && *found == node.image) groups[n] = {found - images.begin(), 1, -1};
      continue;
    }
    const Group &a = groups[static_cast<std::size_t>(node.low)], &b = groups[static_cast<std::size_t>(node.high)];
    if (a.place < 0 || b.place < 0) {
      groups[n] = a.place < 0 ? b : a;
      continue;
    }
    const double total = a.count + b.count;
    for (const int child : {a.step, b.step})
      if (child >= 0) plan.steps[static_cast<std::size_t>(child)].parent = static_cast<Eigen::Index>(plan.steps.size());
    plan.steps.push_back({.into = a.place,
                          .from = b.place,
                          .weight_into = std::sqrt(a.count / total),
                          .weight_from = std::sqrt(b.count / total),
                          .coefficient = 0,
                          .parent = -1});
    depths.push_back(node.depth);
    groups[n] = {a.place, total, static_cast<int>(plan.steps.size()) - 1};
  }
  // Coefficients by depth; `parent` held the step so far.
  std::vector<std::size_t> order(plan.steps.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depths[a] < depths[b]; });
  for (std::size_t i = 0; i < order.size(); ++i) plan.steps[order[i]].coefficient = static_cast<Eigen::Index>(i) + 1;
  for (Plan::Step& step : plan.steps)
    step.parent = step.parent < 0 ? 0 : plan.steps[static_cast<std::size_t>(step.parent)].coefficient;
  return plan;
}

void ViewHaar::forward(const Plan& plan, Eigen::Ref<Eigen::VectorXf> values) {
  Eigen::VectorXf coefficients(plan.size);
  Eigen::Index root = 0;
  for (const Plan::Step& step : plan.steps) {
    const float a = values[step.into], b = values[step.from];
    const auto wa = static_cast<float>(step.weight_into), wb = static_cast<float>(step.weight_from);
    coefficients[step.coefficient] = wb * a - wa * b;
    values[step.into] = wa * a + wb * b;
    root = step.into;
  }
  if (plan.size > 0) coefficients[0] = values[root];
  values = coefficients;
}

void ViewHaar::inverse(const Plan& plan, Eigen::Ref<Eigen::VectorXf> coefficients) {
  if (plan.size == 0) return;
  Eigen::VectorXf values(plan.size);
  values[plan.steps.empty() ? 0 : plan.steps.back().into] = coefficients[0];
  for (std::size_t i = plan.steps.size(); i-- > 0;) {
    const Plan::Step& step = plan.steps[i];
    const float sum = values[step.into], difference = coefficients[step.coefficient];
    const auto wa = static_cast<float>(step.weight_into), wb = static_cast<float>(step.weight_from);
    values[step.into] = wa * sum + wb * difference;
    values[step.from] = wb * sum - wa * difference;
  }
  coefficients = values;
}

}  // namespace sheen
