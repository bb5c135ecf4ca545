// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/colmap_run.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>

#include "common/base/child_process.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kLook{50};
constexpr unsigned kMostThreads = 4;
constexpr std::size_t kAllPairs = 80;  ///< photographs; of more each is matched with those near it in their order
constexpr std::size_t kBlock = 8;      ///< photographs whose features are matched at a time: how fine the bar is
constexpr std::size_t kLastLines = 6;

/// No display is opened, and OpenMP adds no threads to those that COLMAP is given.
const std::map<std::string, std::string> kEnvironment = {{"QT_QPA_PLATFORM", "offscreen"}, {"OMP_NUM_THREADS", "1"}};

/// One of COLMAP's commands, and how its log shows how far it is.
struct Step {
  std::string command;
  std::vector<std::string> options;
  std::string label;  ///< of the bar
  std::string sign;   ///< what it prints once for each unit of its work
  std::size_t units = 0;
};

std::string threads() {
  return std::to_string(std::clamp(std::thread::hardware_concurrency(), 1u, kMostThreads));
}

std::string from(const fs::path& log, std::uintmax_t begin) {
  std::ifstream file(log, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(begin));
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::size_t count_of(std::string_view sign, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(sign); at != std::string_view::npos; at = text.find(sign, at + sign.size())) ++count;
  return count;
}

std::string last_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (line.find_first_not_of(" \t\r=") != std::string::npos) lines.push_back(line);
  std::string last;
  for (std::size_t i = lines.size() - std::min(kLastLines, lines.size()); i < lines.size(); ++i)
    last += "\n  " + lines[i];
  return last;
}

fs::path installed_colmap() {
  const fs::path program = program_in_path("colmap");
  if (program.empty())
    throw Error(
        "the photographs have no poses, and COLMAP, which finds them, is not installed. Install it: `sudo apt install "
        "colmap`. Or find them elsewhere, with these commands, and give FOLDER in place of the photographs:\n"
        "  mkdir -p FOLDER/sparse && ln -s \"$PWD/PHOTOS\" FOLDER/images\n"
        "  colmap feature_extractor --database_path FOLDER/db --image_path PHOTOS --SiftExtraction.use_gpu 0 "
        "--ImageReader.single_camera 1\n"
        "  colmap exhaustive_matcher --database_path FOLDER/db --SiftMatching.use_gpu 0\n"
        "  colmap mapper --database_path FOLDER/db --image_path PHOTOS --output_path FOLDER/sparse");
  return program;
}

struct Ran {
  int status = 0;
  std::string printed;
};

/// Runs it to its end.
Ran run(const fs::path& colmap, const Step& step, const fs::path& log) {
  std::error_code none_yet;
  const std::uintmax_t size = fs::file_size(log, none_yet), begin = none_yet ? 0 : size;
  std::vector<std::string> arguments = {step.command, "--log_to_stderr", "1"};
  arguments.insert(arguments.end(), step.options.begin(), step.options.end());
  ChildProcess child(colmap, arguments, kEnvironment, log);
  Progress bar(step.label, step.units);
  std::string printed;
  for (;; std::this_thread::sleep_for(kLook)) {
    const std::optional<int> ended = child.ended();
    printed += from(log, begin + printed.size());
    bar.update(std::min(step.units, count_of(step.sign, printed)));
    if (ended) return {*ended, printed};
    if (stop_requested()) throw Error("stopped while COLMAP worked (" + step.label + "); nothing of it was kept");
  }
}

void require_success(const Step& step, const Ran& ran, const fs::path& log) {
  if (ran.status == 0) return;
  throw Error("`colmap " + step.command + "` failed (" +
              (ran.status > 128 ? "ended by signal " + std::to_string(ran.status - 128)
                                : "exit status " + std::to_string(ran.status)) +
              "); all that it said is in " + log.string() + ", which ends:" + last_lines(ran.printed));
}

void run_or_throw(const fs::path& colmap, const Step& step, const fs::path& log) {
  require_success(step, run(colmap, step, log), log);
}

Step features(const fs::path& images, const fs::path& database, const fs::path& list, std::size_t count) {
  return {.command = "feature_extractor",
          .options = {"--database_path", database.string(), "--image_path", images.string(), "--image_list_path",
                      list.string(), "--ImageReader.single_camera", "1", "--SiftExtraction.use_gpu", "0",
                      "--SiftExtraction.num_threads", threads(), "--SiftExtraction.max_image_size", "2000"},
          .label = "looking for features",
          .sign = "Processed file [",
          .units = count};
}

Step matches(const fs::path& database, std::size_t count) {
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  const bool all = count <= kAllPairs;
  Step step{.command = all ? "exhaustive_matcher" : "sequential_matcher",
            .options = {"--database_path", database.string(), "--SiftMatching.use_gpu", "0",
                        "--SiftMatching.num_threads", threads()},
            .label = "matching features",
            .sign = all ? "Matching block [" : "Matching image [",
            .units = all ? blocks * blocks : count};
  if (all) step.options.insert(step.options.end(), {"--ExhaustiveMatching.block_size", std::to_string(kBlock)});
  return step;
}

Step mapping(const fs::path& images, const fs::path& database, const fs::path& models, std::size_t count) {
  return {.command = "mapper",
          .options = {"--database_path", database.string(), "--image_path", images.string(), "--output_path",
                      models.string(), "--Mapper.num_threads", threads(), "--Mapper.min_model_size", "3",
                      "--Mapper.extract_colors", "0"},
          .label = "placing photographs",
          .sign = "Registering image #",
          .units = count};
}

}  // namespace

void run_colmap(const fs::path& images, const std::vector<OneCamera>& cameras, const fs::path& work,
                const fs::path& log) {
  const fs::path colmap = installed_colmap();
  const fs::path database = work / "database.db", list = work / "photographs.txt", models = work / "sparse";
  make_folder(models);
  std::size_t count = 0;
  for (const OneCamera& camera : cameras) {
    std::string names;
    for (const std::string& name : camera) names += name + "\n";
    write_file(list, names);
    run_or_throw(colmap, features(images, database, list, camera.size()), log);
    count += camera.size();
  }
  run_or_throw(colmap, matches(database, count), log);
  const Step last = mapping(images, database, models, count);
  const Ran ran = run(colmap, last, log);
  if (fs::is_empty(models) && ran.printed.find("failed to create sparse model") != std::string::npos)
    throw Error(
        "COLMAP finds no places for the photographs: they have too little in common. Take more of them, in "
        "steps of 10 to 15 degrees round the object, sharp, with something that has texture in the picture "
        "(a newspaper under the object helps); what COLMAP said is in " +
        log.string());
  require_success(last, ran, log);
  fs::remove(database);
  fs::remove(list);
}

}  // namespace sheen
