// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/photograph_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/quantity.h"
#include "common/datasets/posed_photographs.h"

namespace sheen {
namespace {

std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kNamed ? text + " and " + std::to_string(names.size() - kNamed) + " others" : text;
}

void tell(const PosedPhotographs& posed, bool size_known) {
  const std::size_t placed = posed.photographs - posed.left_out.size();
  std::fprintf(stderr, "COLMAP%s placed %zu of %zu photographs; the data set is %s\n", posed.found_before ? " has" : "",
               placed, posed.photographs, posed.folder.c_str());
  if (posed.groups > 1)
    std::fprintf(
        stderr,
        "the photographs fall into %zu groups that have too little in common; the largest is used. Photographs "
        "between them would join them\n",
        posed.groups);
  if (!posed.left_out.empty()) std::fprintf(stderr, "left out, without a place: %s\n", some_of(posed.left_out).c_str());
  if (!size_known)
    std::fprintf(stderr,
                 "photographs do not tell how large the object is: all lengths are in a unit of their own, although "
                 "they are called metres. Measure the greatest length of the object and give it: --object-size 12cm\n");
}

/// The vertex farthest along a direction.
Eigen::Vector3d farthest(const Mesh& mesh, const Eigen::Vector3d& direction) {
  const Eigen::Vector3f along = direction.cast<float>();
  return std::max_element(mesh.vertices.begin(), mesh.vertices.end(),
                          [&](const auto& a, const auto& b) { return a.dot(along) < b.dot(along); })
      ->cast<double>();
}

/// Between two vertices. From each of many directions the pair of the farthest points is followed until it stays.
double greatest_length(const Mesh& mesh) {
  constexpr int kStarts = 64;
  double greatest = 0;
  for (int i = 0; i < kStarts; ++i) {
    const double z = (i + 0.5) / kStarts, angle = i * 2.399963, r = std::sqrt(1 - z * z);
    Eigen::Vector3d direction(r * std::cos(angle), r * std::sin(angle), z);
    for (double length = 0;;) {
      const Eigen::Vector3d across = farthest(mesh, direction) - farthest(mesh, -direction);
      if (!(across.norm() > length)) break;
      length = across.norm();
      greatest = std::max(greatest, length);
      direction = across / length;
    }
  }
  return greatest;
}

}  // namespace

void ObjectSizeArgument::add_to(Command& command) {
  command.option("--object-size", word,
                 "of photographs without poses: the greatest length of the object between two of its points, measured, "
                 "such as 12cm; without it the size is unknown");
}

std::optional<double> ObjectSizeArgument::metres() const {
  if (word.empty()) return std::nullopt;
  return parse_length_m("--object-size", word, "the greatest length of the object, such as 12cm");
}

std::string with_poses(const std::string& folder, const ObjectSizeArgument& size, const std::string& mesh,
                       nlohmann::json& report) {
  const std::optional<double> metres = size.metres();
  if (!is_photographs_alone(folder)) {
    if (metres)
      throw ConfigError("--object-size: the poses of " + folder + " say how large everything is; leave it out");
    return folder;
  }
  if (!mesh.empty())
    throw ConfigError("--mesh: " + folder +
                      " has photographs without poses, which no mesh stands in the frame of; leave it out, and the "
                      "shape is found in the photographs");
  const PosedPhotographs posed = pose_photographs(folder);
  const bool size_known = metres || posed.size_m;
  tell(posed, size_known);
  report["photographs"] = {{"dataset", posed.folder.string()},
                           {"placed", posed.photographs - posed.left_out.size()},
                           {"of", posed.photographs},
                           {"left_out", posed.left_out},
                           {"size_known", size_known}};
  return posed.folder.string();
}

void bring_to_size(double metres, const std::string& dataset, Mesh& shape, CaptureSet& captures,
                   nlohmann::json& report) {
  const double length = greatest_length(shape), factor = metres / length;
  for (Eigen::Vector3f& vertex : shape.vertices) vertex *= static_cast<float>(factor);
  shape.origin *= factor;
  set_size(dataset, factor, metres);
  report["cell_mm"] = factor * report["cell_mm"].get<double>();
  std::fprintf(stderr, "size: the greatest length of the shape is %s, as measured\n", format("%.4g m", metres).c_str());
  captures = open_capture_set(dataset);
}

}  // namespace sheen
