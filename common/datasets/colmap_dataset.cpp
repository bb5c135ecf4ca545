// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/colmap_dataset.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/datasets/colmap.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

struct Model {
  fs::path folder;
  std::string images_file;
  ColmapCameras cameras;
  std::vector<ColmapImage> images;
  std::string description;
  std::string other_text;                         ///< a sentence where text beside it says otherwise
  std::optional<std::set<std::string>> held_out;  ///< by name, where the model says
};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool holds_model(const fs::path& folder, const std::string& extension) {
  return is_file(folder / ("cameras" + extension)) && is_file(folder / ("images" + extension));
}

/// By their numbers: 2 before 10.
bool numbered_before(const fs::path& a, const fs::path& b) {
  const std::string left = a.filename().string(), right = b.filename().string();
  return std::pair(left.size(), left) < std::pair(right.size(), right);
}

std::vector<fs::path> model_folders(const fs::path& root) {
  std::vector<fs::path> numbered;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "sparse", ignored))
    if (entry.is_directory(ignored)) numbered.push_back(entry.path());
  std::sort(numbered.begin(), numbered.end(), numbered_before);
  std::vector<fs::path> folders = {root};
  folders.insert(folders.end(), numbered.begin(), numbered.end());
  folders.push_back(root / "sparse");
  std::erase_if(folders,
                [](const fs::path& folder) { return !holds_model(folder, ".bin") && !holds_model(folder, ".txt"); });
  return folders;
}

bool same_images(const std::vector<ColmapImage>& a, const std::vector<ColmapImage>& b) {
  constexpr double kNear = 1e-5;  // text has fewer digits
  std::map<std::string, const ColmapImage*> named;
  for (const ColmapImage& image : b) named[image.name] = &image;
  return a.size() == b.size() && std::ranges::all_of(a, [&](const ColmapImage& image) {
           const auto other = named.find(image.name);
           return other != named.end() && image.rotation_wxyz.isApprox(other->second->rotation_wxyz, kNear) &&
                  (image.translation - other->second->translation).norm() <=
                      kNear * std::max(1.0, image.translation.norm());
         });
}

/// A model as text beside the binary one that is read: as an older run left it, or as a person has changed it.
std::string other_than_text(const fs::path& folder, const std::vector<ColmapImage>& images) {
  const fs::path text = folder / "images.txt";
  if (!is_file(text)) return {};
  const std::string said = (folder / "images.bin").string() + " is read, and not images.txt beside it, ";
  const std::string remedy = ". If the text is the one you mean, move the .bin files away";
  try {
    const auto others = parse_colmap_images_text(text.string(), read_file(text));
    if (same_images(images, others)) return {};
    return said + "which has other images or poses (" + std::to_string(others.size()) + " of them)" + remedy;
  } catch (const FileError&) {
    return said + "which cannot be read" + remedy;
  }
}

std::set<std::string> lines_of(const std::string& text) {
  std::set<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (!line.empty()) lines.insert(normal_name(line));
  }
  return lines;
}

Model read_model(const fs::path& folder) {
  const bool binary = holds_model(folder, ".bin");
  const fs::path cameras = folder / (binary ? "cameras.bin" : "cameras.txt");
  Model model{.folder = folder, .images_file = (folder / (binary ? "images.bin" : "images.txt")).string()};
  const std::string cameras_bytes = read_file(cameras), images_bytes = read_file(model.images_file);
  model.cameras = binary ? parse_colmap_cameras_binary(cameras.string(), cameras_bytes)
                         : parse_colmap_cameras_text(cameras.string(), cameras_bytes);
  model.images = binary ? parse_colmap_images_binary(model.images_file, images_bytes)
                        : parse_colmap_images_text(model.images_file, images_bytes);
  if (binary) model.other_text = other_than_text(folder, model.images);
  model.description = content_hash(cameras_bytes) + content_hash(images_bytes);
  if (const fs::path list = folder / kColmapHeldOut; is_file(list)) {
    const std::string names = read_file(list);
    model.held_out = lines_of(names);
    model.description += content_hash(names);
  }
  return model;
}

/// What `test.txt` says, for a person; empty where there is none. A name that no image has is a list of other images.
std::string mark_held_out(const Model& model, std::vector<DatasetView>& views) {
  if (!model.held_out) return {};
  const std::string file = (model.folder / kColmapHeldOut).string();
  std::set<std::string> unknown = *model.held_out;
  for (const ColmapImage& image : model.images) unknown.erase(normal_name(image.name));
  if (!unknown.empty()) throw FileError(file, "the model has no image \"" + *unknown.begin() + "\"");
  for (DatasetView& view : views)
    view.purpose = model.held_out->contains(normal_name(view.name)) ? Purpose::kHeldOut : Purpose::kTraining;
  return file + ": its " + std::to_string(model.held_out->size()) + " images are held out";
}

std::string in_words(const Model& model) {
  return model.folder.string() + " (" + std::to_string(model.images.size()) + " images)";
}

std::string choice_of(const std::vector<Model>& models, const Model& chosen) {
  if (models.size() == 1) return chosen.other_text;
  std::string others;
  for (const Model& model : models)
    if (&model != &chosen) others += (others.empty() ? "" : ", ") + in_words(model);
  return std::to_string(models.size()) +
         " COLMAP models, of which one is read, the first of those with most images: " + in_words(chosen) +
         "; not read: " + others + ". Their frames differ; merge them in COLMAP to use all" +
         (chosen.other_text.empty() ? "" : "\n" + chosen.other_text);
}

DatasetView view_of(const Model& model, const ColmapImage& image) {
  const auto fail = [&](const std::string& what) {
    throw FileError(model.images_file, "image " + image.name + ": " + what);
  };
  DatasetView view;
  view.name = image.name;
  std::replace(view.name.begin(), view.name.end(), '\\', '/');
  try {
    view.camera_from_object = colmap_pose(image);
  } catch (const Error& error) {
    fail(error.what());
  }
  const auto camera = model.cameras.find(image.camera_id);
  if (camera == model.cameras.end()) fail("there is no camera " + std::to_string(image.camera_id));
  view.camera = camera->second;
  return view;
}

}  // namespace

fs::path find_colmap_mask(const FileFinder& finder, const std::string& image) {
  const fs::path within = fs::path(image).parent_path();
  const std::string stem = fs::path(image).stem().string();
  const auto beside = [&](const std::string& name) { return (within / name).string(); };
  for (const char* folder : {"masks/", "mask/"}) {
    for (const std::string& name : {image + ".png", image})
      if (const fs::path mask = finder.find(folder + name); !mask.empty()) return mask;
    for (const std::string& name : {stem, stem + "_mask", stem + "-mask", stem + ".mask", "mask_" + stem})
      if (const fs::path mask = finder.find_image(folder + beside(name)); !mask.empty()) return mask;
  }
  for (const char* folder : {"images/", ""})
    if (const fs::path mask = finder.find_image(folder + beside(stem + "_mask")); !mask.empty()) return mask;
  return {};
}

bool holds_colmap(const fs::path& root) {
  return !model_folders(root).empty();
}

std::optional<ColmapViews> load_colmap(const fs::path& root, const fs::path& images, ImageAccount& account) {
  std::vector<Model> models;
  for (const fs::path& folder : model_folders(root)) models.push_back(read_model(folder));
  if (models.empty()) return std::nullopt;
  const Model& model = *std::max_element(
      models.begin(), models.end(), [](const Model& a, const Model& b) { return a.images.size() < b.images.size(); });
  if (model.images.empty()) throw FileError(model.images_file, "holds no image");
  ColmapViews colmap{
      .views = {}, .models = models.size(), .description = model.description, .remarks = choice_of(models, model)};
  const FileFinder finder(images);
  std::set<std::string> names;
  for (const ColmapImage& image : model.images) {
    DatasetView view = view_of(model, image);
    if (!names.insert(view.name).second) throw FileError(model.images_file, "image " + image.name + " is listed twice");
    view.image_path = finder.find("images/" + view.name);
    if (view.image_path.empty()) view.image_path = finder.find(view.name);
    if (view.image_path.empty()) {
      account.left_out.push_back(
          {image.name, "there is no such image in " + images.string() + " or its folder images"});
      continue;
    }
    if (const fs::path mask = find_colmap_mask(finder, view.name); !mask.empty()) view.mask_path = mask;
    colmap.views.push_back(std::move(view));
  }
  const std::string held_out = mark_held_out(model, colmap.views);
  colmap.remarks += (colmap.remarks.empty() || held_out.empty() ? "" : "\n") + held_out;
  return colmap;
}

}  // namespace sheen
