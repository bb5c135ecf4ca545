// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/dataset.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/datasets/camera_path.h"
#include "common/datasets/colmap_dataset.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/image_inspection.h"
#include "common/datasets/transforms_json.h"
#include "common/image/image_io.h"

namespace sheen {

namespace {

namespace fs = std::filesystem;

/// Views as they are described, their images not yet looked at.
struct Description {
  std::vector<DatasetView> views;
  std::string contents;  ///< what names it
  std::string remark;
};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

Description read_transforms(const fs::path& file, ImageAccount& account) {
  const FileFinder finder(file.parent_path());
  Description description{.views = {}, .contents = read_file(file), .remark = {}};
  description.views = parse_transforms(file.string(), description.contents,
                                       {.find = [&](const std::string& name) { return finder.find_image(name); },
                                        .size = read_image_size,
                                        .left_out =
                                            [&](const std::string& name, const std::string& why) {
                                              account.left_out.push_back({name, why, finder.find_image(name)});
                                            }});
  return description;
}

/// One file for training and one for testing, as NeRF's synthetic scenes have it.
std::optional<Description> read_split_transforms(const fs::path& root, ImageAccount& account) {
  const fs::path train = root / "transforms_train.json", val = root / "transforms_val.json";
  if (!is_file(train)) return std::nullopt;
  const fs::path test = is_file(root / "transforms_test.json") ? root / "transforms_test.json" : val;
  Description all = read_transforms(train, account);
  for (DatasetView& view : all.views) view.purpose = Purpose::kTraining;
  all.remark = train.string() + ": its views are used to build";
  if (is_file(test)) {
    const Description held_out = read_transforms(test, account);
    for (const DatasetView& view : held_out.views) all.views.emplace_back(view).purpose = Purpose::kHeldOut;
    all.contents = content_hash(all.contents) + content_hash(held_out.contents);
    all.remark += ", those of " + test.filename().string() + " are held out";
  }
  if (test != val && is_file(val)) all.remark += "; " + val.filename().string() + " is not read";
  return all;
}

Description read_description(const fs::path& folder, const fs::path& root, ImageAccount& account) {
  std::error_code ignored;
  const fs::path transforms = fs::is_directory(folder, ignored) ? folder / "transforms.json" : folder;
  if (is_file(transforms)) return read_transforms(transforms, account);
  if (const auto split = read_split_transforms(root, account)) return *split;
  if (auto colmap = load_colmap(root, root, account))
    return {std::move(colmap->views), colmap->description, colmap->remarks};
  throw FileError(folder.string(),
                  "holds neither a transforms.json (or transforms_train.json) nor a COLMAP model (cameras and images, "
                  ".bin or .txt); of photographs alone (JPEG, PNG or WebP) `build` and `shape` find the poses");
}

/// Two views of one file would be two photographs of the same pixels, or a test view that was trained with.
void refuse_shared_images(const fs::path& folder, const std::vector<DatasetView>& views) {
  std::map<fs::path, std::string> names;
  for (const DatasetView& view : views)
    if (const auto [first, is_new] = names.emplace(view.image_path.lexically_normal(), view.name); !is_new)
      throw FileError(folder.string(),
                      "\"" + first->second + "\" and \"" + view.name + "\" are one image, " + view.image_path.string());
}

/// Files that no view names; one that is named and cannot be read is not among them.
void look_for_others(const fs::path& root, const std::vector<DatasetView>& views, ImageAccount& account) {
  std::vector<fs::path> images, masks;
  for (const DatasetView& view : views) {
    images.push_back(view.image_path);
    if (view.mask_path) masks.push_back(*view.mask_path);
  }
  look_for_unused(account, root, images, masks);
}

/// Looks at all files; only views that can be used stay. @return the hash of what they deliver. Images are hashed
/// rather than dated: a copy of the folder is the same data set, and an image that was drawn again is another one.
std::string inspect_all(std::vector<DatasetView>& views, const std::string& description, ImageAccount& account) {
  std::vector<ImageInspection> found(views.size());
  Progress progress("looking at images", views.size());
  std::mutex told;
  std::size_t done = 0;
  constexpr int kAtOnce = 4;  // each holds a decoded image
  tbb::task_arena(std::min(kAtOnce, tbb::this_task_arena::max_concurrency())).execute([&] {
    tbb::parallel_for(std::size_t(0), views.size(), [&](std::size_t i) {
      found[i] = inspect(views[i]);
      const std::lock_guard lock(told);
      progress.update(++done);
    });
  });
  std::string contents = content_hash(description);
  std::vector<DatasetView> usable;
  std::size_t alphas = 0, files = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!found[i].damage.empty()) {
      account.left_out.push_back({views[i].name, found[i].damage});
      continue;
    }
    contents += found[i].contents;
    if (views[i].mask_path) {
      ++files;
      account.unused_alphas += found[i].alpha;
    } else {
      alphas += found[i].alpha;
    }
    if (!found[i].other_colours.empty()) account.other_colours[found[i].other_colours].push_back(views[i].name);
    if (found[i].grey) account.grey.push_back(views[i].name);
    usable.push_back(std::move(views[i]));
  }
  views = std::move(usable);
  account.masks = files + alphas;
  account.masks_are_alpha = alphas > 0;
  if (account.grey.size() == views.size()) account.grey.clear();
  return content_hash(contents);
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
         "to the rotated picture, rotate the files themselves (exiftran -a)";
}

std::string description(const Camera& camera) {
  std::string text = std::to_string(static_cast<int>(camera.lens));
  for (const double value : {double(camera.width), double(camera.height), camera.fx, camera.fy, camera.cx, camera.cy})
    text += " " + std::to_string(value);
  for (const double k : camera.distortion) text += " " + std::to_string(k);
  return text;
}

void require_size(const DatasetView& view, const fs::path& path, const ImageSize& size) {
  const Camera& camera = view.camera;
  if (size.width == camera.width && size.height == camera.height) return;
  const bool turned = view.exif_orientation > 4 && size.width == camera.height && size.height == camera.width;
  throw FileError(
      path.string(),
      "is " + std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels, but its camera is " +
          std::to_string(camera.width) + " x " + std::to_string(camera.height) +
          (turned ? "; its EXIF data say that it must be rotated: rotate the file itself (exiftran -a)" : ""));
}

}  // namespace

bool holds_poses(const fs::path& folder) {
  return is_file(folder / "transforms.json") || is_file(folder / "transforms_train.json") || holds_colmap(folder);
}

Dataset load_dataset(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) throw FileError(folder.string(), "no such folder");
  Dataset dataset;
  dataset.root = fs::is_directory(folder, ignored) ? folder : folder.parent_path();
  ImageAccount& account = dataset.account;
  Description description = read_description(folder, dataset.root, account);
  refuse_shared_images(folder, description.views);
  account.images = description.views.size();
  account.of = account.images + account.left_out.size();
  refuse_few(folder, account);
  look_for_others(dataset.root, description.views, account);
  dataset.hash = inspect_all(description.views, description.contents, account);
  account.images = description.views.size();
  refuse_few(folder, account);
  dataset.views = std::move(description.views);
  const std::string orientation = orientation_warning(dataset.views);
  dataset.warning = description.remark + (description.remark.empty() || orientation.empty() ? "" : "\n") + orientation;
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

void check_sizes(const Dataset& dataset) {
  for (const DatasetView& view : dataset.views) {
    require_size(view, view.image_path, view.image_size);
    if (view.mask_path) require_size(view, *view.mask_path, view.mask_size);
  }
}

Capture read_capture(const Dataset& dataset, std::size_t index) {
  const DatasetView& view = dataset.views.at(index);
  Capture capture;
  capture.source_session = "dataset:" + dataset.hash;
  capture.sequence = index + 1;
  capture.camera_frame_id = index;
  capture.name = view.name;
  capture.camera = view.camera;
  MaskedImage masked = read_masked_image(view.image_path);
  capture.image = std::move(masked.image);
  capture.mask = view.mask_path ? read_mask(*view.mask_path) : std::move(masked.mask);
  require_size(view, view.image_path, {capture.image.width, capture.image.height});
  if (view.mask_path) require_size(view, *view.mask_path, {capture.mask.width(), capture.mask.height()});
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
