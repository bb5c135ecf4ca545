// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/posed_photographs.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/datasets/colmap_dataset.h"
#include "common/datasets/colmap_run.h"
#include "common/datasets/dataset.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/photograph_frame.h"
#include "common/image/exif.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewest = 3;

/// Beside the `transforms.json`: of which photographs it is, and the measured length.
constexpr const char* kNote = "photographs.json";
constexpr const char* kTransforms = "transforms.json";

/// The names of the photographs in a folder, in their order.
std::vector<std::string> photographs_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string extension = loose_name(entry.path().extension().string());
    const bool read = extension == ".jpg" || extension == ".jpeg" || extension == ".png" || extension == ".webp";
    const std::string stem = loose_name(entry.path().stem().string());
    if (read && !stem.ends_with("_mask") && entry.is_regular_file(ignored))
      names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path beside(const fs::path& folder, const std::string& ending) {
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (whole.filename().empty()) whole = whole.parent_path();
  return whole.parent_path() / (whole.filename().string() + ending);
}

struct Photographs {
  fs::path folder;
  std::vector<std::string> names;
  std::vector<OneCamera> cameras;  ///< by their sizes
  std::string hash;                ///< of names and bytes
};

Photographs look_at_photographs(const fs::path& folder) {
  Photographs photographs{.folder = folder, .names = photographs_in(folder), .cameras = {}, .hash = {}};
  std::map<std::pair<int, int>, OneCamera> of_size;
  std::string contents;
  Progress bar("looking at photographs", photographs.names.size());
  for (std::size_t i = 0; i < photographs.names.size(); ++i) {
    const std::string& name = photographs.names[i];
    contents += name + "\n" + content_hash_of_file(folder / name) + "\n";
    try {
      const ImageSize size = read_image_size(folder / name);
      of_size[{size.width, size.height}].push_back(name);
    } catch (const FileError& damaged) {
      const ProgressPause pause;
      std::fprintf(stderr, "left out: %s\n", damaged.what());
    }
    bar.update(i + 1);
  }
  for (auto& [size, camera] : of_size) photographs.cameras.push_back(std::move(camera));
  photographs.hash = content_hash(contents);
  return photographs;
}

nlohmann::json read_note(const fs::path& posed) {
  const auto note = nlohmann::json::parse(read_file(posed / kNote), nullptr, false);
  if (!note.is_object() || !note.contains("photographs") || !note["photographs"].is_string())
    throw FileError((posed / kNote).string(), "is not what was written there; remove the folder");
  return note;
}

void write_note(const fs::path& posed, const nlohmann::json& note) {
  write_file(posed / kNote, note.dump(2) + "\n");
}

/// Of a folder that is there: whether it is of these photographs as they are now.
bool is_of(const Photographs& photographs, const fs::path& posed) {
  if (!fs::exists(posed)) return false;
  if (!fs::exists(posed / kNote))
    throw FileError(posed.string(),
                    "the poses of the photographs are to be kept there, but it is another folder; "
                    "rename it, or give it in place of the photographs if it has their poses");
  return read_note(posed)["photographs"] == photographs.hash && fs::exists(posed / kTransforms);
}

std::vector<std::string> without_pose(const Photographs& photographs, const std::vector<DatasetView>& views) {
  std::set<std::string> placed;
  for (const DatasetView& view : views) placed.insert(fs::path(view.name).filename().string());
  std::vector<std::string> left_out;
  for (const std::string& name : photographs.names)
    if (!placed.contains(name)) left_out.push_back(name);
  return left_out;
}

/// Writes the data set into `work`, where COLMAP has put its models, as it will be read in `posed`.
PosedPhotographs write_posed(const Photographs& photographs, const fs::path& work, const fs::path& posed) {
  ImageAccount account;
  auto colmap = load_colmap(work / "colmap", photographs.folder, account);
  if (!colmap) throw FileError((work / "colmap").string(), "COLMAP has written no model that can be read");
  std::vector<DatasetView>& views = colmap->views;
  std::sort(views.begin(), views.end(), [](const DatasetView& a, const DatasetView& b) { return a.name < b.name; });
  for (DatasetView& view : views) view.exif_orientation = read_exif_orientation(read_file(view.image_path));
  bring_to_plain_frame(views);
  PosedPhotographs result{.folder = posed,
                          .photographs = photographs.names.size(),
                          .groups = colmap->models,
                          .left_out = without_pose(photographs, views)};
  for (DatasetView& view : views) view.name = relative_name(fs::absolute(view.image_path).lexically_normal(), posed);
  write_transforms(work / kTransforms, views);
  write_note(work, {{"photographs", photographs.hash}});
  return result;
}

PosedPhotographs read_posed(const Photographs& photographs, const fs::path& posed) {
  PosedPhotographs result{.folder = posed,
                          .photographs = photographs.names.size(),
                          .groups = 0,
                          .left_out = without_pose(photographs, load_cameras(posed / kTransforms)),
                          .found_before = true};
  if (const auto note = read_note(posed); note.contains("size_m") && note["size_m"].is_number())
    result.size_m = note["size_m"].get<double>();
  return result;
}

}  // namespace

bool is_photographs_alone(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder, ignored) && !holds_poses(folder) && !photographs_in(folder).empty();
}

PosedPhotographs pose_photographs(const fs::path& folder) {
  const Photographs photographs = look_at_photographs(folder);
  const fs::path posed = beside(folder, ".posed"), log = beside(folder, ".posed.log");
  if (is_of(photographs, posed)) return read_posed(photographs, posed);
  if (photographs.names.size() < kFewest)
    throw FileError(folder.string(), "holds " + std::to_string(photographs.names.size()) +
                                         " photographs without poses; a shape needs more, 20 at least, in steps of 10 "
                                         "to 15 degrees round the object");
  fs::remove_all(posed);  // of other photographs
  fs::remove(log);
  NewFolder made(posed);
  run_colmap(folder, photographs.cameras, made.unfinished() / "colmap", log);
  PosedPhotographs result = write_posed(photographs, made.unfinished(), posed);
  made.finish();
  return result;
}

void set_size(const fs::path& posed, double factor, double size_m) {
  std::vector<DatasetView> views = load_cameras(posed / kTransforms);
  scale_poses(views, factor);
  write_transforms(posed / kTransforms, views);
  nlohmann::json note = read_note(posed);
  note["size_m"] = size_m;
  write_note(posed, note);
}

}  // namespace sheen
