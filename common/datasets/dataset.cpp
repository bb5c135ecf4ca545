// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/dataset.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/datasets/camera_path.h"
#include "common/datasets/colmap.h"
#include "common/datasets/transforms_json.h"
#include "common/image/exif.h"
#include "common/image/image_io.h"

namespace sheen {

namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// The file itself, or the picture that it names without its extension. Empty when there is neither.
fs::path find_image(const fs::path& root, const std::string& name) {
  const fs::path path = root / fs::path(name).lexically_normal();
  if (is_file(path)) return path;
  for (const char* extension : {".png", ".jpg", ".jpeg", ".webp", ".exr", ".PNG", ".JPG", ".JPEG", ".WEBP", ".EXR"})
    if (const fs::path candidate = path.string() + extension; is_file(candidate)) return candidate;
  return {};
}

/// Of all that the views deliver: description, images and masks, in their order. Images are hashed rather than dated:
/// a copy of the folder is the same data set, and an image that was drawn again is another one.
std::string identity(const std::string& description, const std::vector<DatasetView>& views) {
  std::string contents = content_hash(description);
  for (const DatasetView& view : views) {
    contents += content_hash_of_file(view.image_path);
    contents += view.mask_path ? content_hash_of_file(*view.mask_path) : "no mask";
  }
  return content_hash(contents);
}

Dataset load_transforms(const fs::path& file) {
  Dataset dataset;
  dataset.root = file.parent_path();
  const std::string text = read_file(file);
  dataset.views = parse_transforms(
      file.string(), text, {[&](const std::string& name) { return find_image(dataset.root, name); }, read_image_size});
  dataset.hash = identity(text, dataset.views);
  return dataset;
}

DatasetView colmap_view(const fs::path& root, const std::string& file, const ColmapImage& image,
                        const ColmapCameras& cameras) {
  const auto fail = [&](const std::string& what) { throw FileError(file, "image " + image.name + ": " + what); };
  DatasetView view;
  view.name = image.name;
  try {
    view.camera_from_object = colmap_pose(image);
  } catch (const Error& error) {
    fail(error.what());
  }
  const auto camera = cameras.find(image.camera_id);
  if (camera == cameras.end()) fail("there is no camera " + std::to_string(image.camera_id));
  view.camera = camera->second;
  const fs::path in_images = root / "images" / image.name, in_root = root / image.name;
  view.image_path = is_file(in_images) ? in_images : in_root;
  if (!is_file(view.image_path)) fail("there is no such image in " + root.string() + " or its folder images");
  if (const fs::path mask = root / "masks" / (image.name + ".png"); is_file(mask)) view.mask_path = mask;
  return view;
}

Dataset load_colmap(const fs::path& root, const fs::path& model) {
  const bool binary = is_file(model / "cameras.bin") && is_file(model / "images.bin");
  const fs::path cameras_file = model / (binary ? "cameras.bin" : "cameras.txt");
  const fs::path images_file = model / (binary ? "images.bin" : "images.txt");
  const std::string cameras_bytes = read_file(cameras_file), images_bytes = read_file(images_file);
  const ColmapCameras cameras = binary ? parse_colmap_cameras_binary(cameras_file.string(), cameras_bytes)
                                       : parse_colmap_cameras_text(cameras_file.string(), cameras_bytes);
  const std::vector<ColmapImage> images = binary ? parse_colmap_images_binary(images_file.string(), images_bytes)
                                                 : parse_colmap_images_text(images_file.string(), images_bytes);
  if (images.empty()) throw FileError(images_file.string(), "holds no image");
  Dataset dataset;
  dataset.root = root;
  std::set<std::string> names;
  for (const ColmapImage& image : images) {
    if (!names.insert(image.name).second)
      throw FileError(images_file.string(), "image " + image.name + " is listed twice");
    dataset.views.push_back(colmap_view(root, images_file.string(), image, cameras));
  }
  dataset.hash = identity(content_hash(cameras_bytes) + content_hash(images_bytes), dataset.views);
  return dataset;
}

/// The folder below `root` that holds a COLMAP model; empty when there is none.
fs::path find_colmap(const fs::path& root) {
  for (const fs::path& folder : {root, root / "sparse" / "0", root / "sparse"})
    for (const char* extension : {".bin", ".txt"})
      if (is_file(folder / (std::string("cameras") + extension)) &&
          is_file(folder / (std::string("images") + extension)))
        return folder;
  return {};
}

void add_exif(DatasetView& view) {
  constexpr std::size_t kBytesBeforePixels = 1 << 18;
  const std::string start = read_file_start(view.image_path, kBytesBeforePixels);
  view.exif_orientation = read_exif_orientation(start);
  const auto exif = read_exif_exposure(start);
  if (!exif) return;
  view.exposure_s = exif->exposure_s;
  const double iso = exif->iso > 0 ? exif->iso : 100, f_number = exif->f_number > 0 ? exif->f_number : 1;
  view.gain_db = 20 * std::log10(iso / 100 / (f_number * f_number));
}

/// Turning the pixels would part them from poses that were found in the stored picture, as COLMAP finds them; leaving
/// them would, where a tool has turned them before. Only the user knows.
std::string orientation_warning(const std::vector<DatasetView>& views) {
  const auto turned = [](const DatasetView& view) { return view.exif_orientation != 1; };
  const auto first = std::find_if(views.begin(), views.end(), turned);
  if (first == views.end()) return {};
  const auto others = std::count_if(first + 1, views.end(), turned);
  return first->image_path.string() + (others > 0 ? " and " + std::to_string(others) + " others" : "") +
         ": EXIF says that the picture must be rotated; the pixels are used as they are stored. If the poses belong "
         "to "
         "the rotated picture, rotate the files themselves (exiftran -a)";
}

std::string description(const Camera& camera) {
  std::string text = std::to_string(static_cast<int>(camera.lens));
  for (const double value : {double(camera.width), double(camera.height), camera.fx, camera.fy, camera.cx, camera.cy})
    text += " " + std::to_string(value);
  for (const double k : camera.distortion) text += " " + std::to_string(k);
  return text;
}

}  // namespace

Dataset load_dataset(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) throw FileError(folder.string(), "no such folder");
  const fs::path root = fs::is_directory(folder, ignored) ? folder : folder.parent_path();
  const fs::path transforms = fs::is_directory(folder, ignored) ? folder / "transforms.json" : folder;
  const fs::path colmap = find_colmap(root);
  Dataset dataset;
  if (is_file(transforms))
    dataset = load_transforms(transforms);
  else if (!colmap.empty())
    dataset = load_colmap(root, colmap);
  else
    throw FileError(folder.string(),
                    "holds neither a transforms.json nor a COLMAP model (cameras and images, .bin or .txt)");
  for (DatasetView& view : dataset.views) add_exif(view);
  dataset.warning = orientation_warning(dataset.views);
  return dataset;
}

std::vector<DatasetView> load_cameras(const fs::path& transforms_json) {
  const auto no_size = [&](const fs::path& image) -> ImageSize {
    throw FileError(transforms_json.string(), image.string() + ": w and h are missing");
  };
  const std::string text = read_file(transforms_json);
  if (auto path = parse_camera_path(transforms_json.string(), text)) return *std::move(path);
  return parse_transforms(transforms_json.string(), text,
                          {[&](const std::string& name) { return transforms_json.parent_path() / name; }, no_size},
                          UnknownNames::kIgnored);
}

Capture read_capture(const Dataset& dataset, std::size_t index) {
  const DatasetView& view = dataset.views.at(index);
  Capture capture;
  capture.source_session = "dataset:" + dataset.hash;
  capture.sequence = index + 1;
  capture.camera_frame_id = index;
  capture.name = view.name;
  capture.camera = view.camera;
  capture.image = read_image(view.image_path);
  const auto check_size = [&](const fs::path& path, int width, int height) {
    if (width == view.camera.width && height == view.camera.height) return;
    const bool turned = view.exif_orientation > 4 && width == view.camera.height && height == view.camera.width;
    throw FileError(path.string(), "is " + std::to_string(width) + " x " + std::to_string(height) +
                                       " pixels, but its camera is " + std::to_string(view.camera.width) + " x " +
                                       std::to_string(view.camera.height) +
                                       (turned ? "; its EXIF data say that it must be rotated: rotate the file itself "
                                                 "(exiftran -a)"
                                               : ""));
  };
  check_size(view.image_path, capture.image.width, capture.image.height);
  if (view.mask_path) {
    capture.mask = read_mask(*view.mask_path);
    check_size(*view.mask_path, capture.mask.width(), capture.mask.height());
  }
  capture.exposure.exposure_s = view.exposure_s.value_or(0);
  capture.exposure.gain_db = view.gain_db;
  capture.exposure.locked = view.exposure_locked;
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = view.camera_from_object;
  capture.light = view.light;
  capture.verdict = FrameVerdict::kKeyframe;
  capture.purpose = view.purpose;
  capture.calibration_hash = content_hash(description(view.camera));
  return capture;
}

}  // namespace sheen
