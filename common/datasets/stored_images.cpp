// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/stored_images.h"

#include <memory>

#include "common/datasets/dataset.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/light_list.h"

namespace sheen {
namespace {

StoredImages of_list(const std::filesystem::path& path) {
  auto list = std::make_shared<const LightList>(load_light_list(path));
  MotionWatch watch;
  for (const LitView& view : list->views) watch.look(list->camera, view.light);
  return {.size = list->views.size(),
          .session = "lights:" + list->hash,
          .cameras = {list->camera},
          .files = list->images,
          .motion = watch.motion(),
          .account = list->account,
          .summary = in_words(list->account, path.parent_path()),
          .warning = list->doubt,
          .read = [list](std::size_t i) { return read_capture(*list, i); }};
}

StoredImages of_dataset(const std::filesystem::path& path) {
  auto dataset = std::make_shared<const Dataset>(load_dataset(path));
  check_sizes(*dataset);
  StoredImages images{.size = dataset->views.size(),
                      .session = "dataset:" + dataset->hash,
                      .cameras = {},
                      .files = {},
                      .motion = {},
                      .account = dataset->account,
                      .summary = in_words(dataset->account, dataset->root),
                      .warning = dataset->warning,
                      .read = [dataset](std::size_t i) { return read_capture(*dataset, i); }};
  MotionWatch watch;
  for (const DatasetView& view : dataset->views) {
    images.cameras.push_back({view.camera, view.camera_from_object});
    images.files.push_back(view.image_path);
    watch.look(images.cameras.back(), view.light);
  }
  images.motion = watch.motion();
  return images;
}

}  // namespace

bool is_light_list(const std::filesystem::path& path) {
  return loose_name(path.extension().string()) == ".lp";
}

StoredImages open_stored_images(const std::filesystem::path& path) {
  return is_light_list(path) ? of_list(path) : of_dataset(path);
}

}  // namespace sheen
