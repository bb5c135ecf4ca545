// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/bench/program_run.h"

namespace sheen {

struct ImageScores {
  double psnr_db = 0, ssim = 0;
};

/// `sheen-reconstructor` on one data set; what it writes goes to a folder. Throws Error where it fails.
class ReconstructorRuns {
 public:
  ReconstructorRuns(std::filesystem::path dataset, std::filesystem::path folder);

  ProgramRun find_shape() const;
  std::filesystem::path shape() const { return folder_ / "shape.ply"; }
  double share_seen() const;  ///< of its vertices

  void refine_shape() const;
  std::filesystem::path refined_shape() const { return folder_ / "refined.ply"; }

  /// Refined first, as `build` does unless it is told not to. With the found shape that is what `build` without --mesh
  /// makes.
  std::filesystem::path model_on(const std::filesystem::path& mesh) const;
  /// Means over held-out images, on the pixels of a mesh; of none: of the model's own.
  ImageScores scores(const std::filesystem::path& model, const std::filesystem::path& object = {}) const;

 private:
  nlohmann::json report(const std::string& name) const;
  std::string json(const std::string& name) const { return folder_ / (name + ".json"); }
  ProgramRun run(std::vector<std::string> arguments) const;

  std::filesystem::path dataset_, folder_;
};

}  // namespace sheen
