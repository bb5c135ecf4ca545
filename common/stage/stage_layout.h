// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

/// One AprilTag on the stage. The stage lies in the plane z = 0 of the object frame, z up.
struct StageTag {
  int id = -1;
  /// Corners of the black square in the object frame, metres, in the order in which `TagObservation` lists them:
  /// seen upright, top left, top right, bottom right, bottom left.
  std::array<Eigen::Vector3d, 4> corners_object;
};

/// Where the tags stand. Tags round the border of a rectangular board, the object in its middle.
struct StageLayout {
  std::string family = "tag36h11";
  double width_m = 0;   ///< along x
  double height_m = 0;  ///< along y
  std::vector<StageTag> tags;

  const StageTag* find(int id) const;
  std::string hash() const;  ///< changes with any tag's id or place
};

struct StageOptions {
  double width_m = 0.40;
  double height_m = 0.30;
  double tag_m = 0.036;     ///< side of a tag's black square
  double margin_m = 0.006;  ///< white border of the board outside the tags' quiet zone
  int first_id = 0;
};

/// Tags round the border, as many as fit with a quiet zone of one tag cell or more. Throws ConfigError.
StageLayout make_stage(const StageOptions& options);

/// JSON; throws FileError naming the field.
StageLayout load_stage(const std::filesystem::path& path);
void save_stage(const StageLayout& stage, const std::filesystem::path& path);

}  // namespace sheen
