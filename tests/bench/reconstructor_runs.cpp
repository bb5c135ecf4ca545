// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/reconstructor_runs.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

namespace sheen {

namespace fs = std::filesystem;

ReconstructorRuns::ReconstructorRuns(fs::path dataset, fs::path folder)
    : dataset_(std::move(dataset)), folder_(std::move(folder)) {
  fs::create_directories(folder_);
}

ProgramRun ReconstructorRuns::find_shape() const {
  return run({"shape", dataset_, "--out", shape(), "--json", json("shape")});
}

double ReconstructorRuns::share_seen() const {
  return report("shape").at("evidence").at("seen").get<double>();
}

void ReconstructorRuns::refine_shape() const {
  run({"refine", dataset_, "--mesh", shape(), "--out", refined_shape()});
}

fs::path ReconstructorRuns::model_on(const fs::path& mesh) const {
  const fs::path model = folder_ / ("model_on_" + mesh.stem().string());
  fs::remove_all(model);
  run({"build", dataset_, "--mesh", mesh, "--out", model, "--loss", "0dB"});
  return model;
}

ImageScores ReconstructorRuns::scores(const fs::path& model, const fs::path& object) const {
  std::vector<std::string> arguments{"evaluate", model, dataset_, "--json", json("evaluate")};
  if (!object.empty()) arguments.insert(arguments.end(), {"--object", object.string()});
  run(arguments);
  const nlohmann::json scores = report("evaluate").at("object");
  return {scores.at("psnr_db").get<double>(), scores.at("ssim").get<double>()};
}

nlohmann::json ReconstructorRuns::report(const std::string& name) const {
  return nlohmann::json::parse(std::ifstream(json(name)));
}

ProgramRun ReconstructorRuns::run(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), fs::read_symlink("/proc/self/exe").parent_path() / "sheen-reconstructor");
  return run_program(arguments, folder_ / (arguments[1] + ".log"));
}

}  // namespace sheen
