// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/light_list.h"
#include "common/image/colour_space.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

/// Empty when there is none.
fs::path image_of(const FileFinder& finder, const std::string& name) {
  if (const fs::path path = finder.find(name); !path.empty()) return path;
  return finder.find(name.substr(name.find_last_of("/\\") + 1));
}

/// A pinhole that looks straight at the origin.
PosedCamera standing_camera(const ImageSize& size) {
  PosedCamera posed;
  const double focal = std::max(size.width, size.height);
  posed.camera = {.width = size.width,
                  .height = size.height,
                  .fx = focal,
                  .fy = focal,
                  .cx = (size.width - 1) / 2.0,
                  .cy = (size.height - 1) / 2.0};
  posed.camera_from_object.rotation =
      Eigen::Quaterniond(0, 1, 0, 0);  // y up and z towards the eye become down and away
  posed.camera_from_object.translation = {0, 0, 1};
  return posed;
}

/// One after the other: only those that can be read are kept.
void take_images(LightList& lights, const fs::path& list, std::vector<LitView> views) {
  const FileFinder finder(list.parent_path());
  ImageSize first;
  std::vector<fs::path> named;
  for (LitView& view : views) {
    const fs::path image = image_of(finder, view.name);
    if (image.empty()) {
      lights.account.left_out.push_back({view.name, "there is no such image beside " + list.filename().string()});
      continue;
    }
    named.push_back(image);
    RawImage pixels;
    try {
      pixels = read_image(image);
    } catch (const FileError& error) {
      lights.account.left_out.push_back({view.name, error.what()});
      continue;
    }
    if (lights.images.empty()) first = {pixels.width, pixels.height};
    if (pixels.width != first.width || pixels.height != first.height)
      throw FileError(image.string(), "is " + std::to_string(pixels.width) + " x " + std::to_string(pixels.height) +
                                          " pixels, but " + lights.images.front().string() + " is " +
                                          std::to_string(first.width) + " x " + std::to_string(first.height) +
                                          ": all images of a list are of one camera that stands still");
    if (const std::string space = other_colour_space(read_file(image)); !space.empty())
      lights.account.other_colours[space].push_back(view.name);
    lights.images.push_back(image);
    lights.views.push_back(std::move(view));
  }
  lights.account.images = lights.views.size();
  lights.account.of = views.size();
  look_for_unused(lights.account, list.parent_path(), named, {});
  lights.camera = standing_camera(first);
}

}  // namespace

LightList load_light_list(const fs::path& list) {
  const std::string text = read_file(list, kMostListBytes);
  std::vector<LitView> views = parse_light_list(list.string(), text);
  LightList lights{.doubt = assumption_about(list.string(), text, views)};
  take_images(lights, list, std::move(views));
  refuse_few(list, lights.account);
  std::string contents = content_hash(text);
  for (const fs::path& image : lights.images) contents += content_hash_of_file(image);
  lights.hash = content_hash(contents);
  return lights;
}

Capture read_capture(const LightList& list, std::size_t index) {
  Capture capture;
  capture.source_session = "lights:" + list.hash;
  capture.sequence = index + 1;
  capture.camera_frame_id = index;
  capture.name = list.views.at(index).name;
  capture.camera = list.camera.camera;
  capture.image = read_image(list.images.at(index));
  if (capture.image.width != capture.camera.width || capture.image.height != capture.camera.height)
    throw FileError(list.images[index].string(), "has changed its size");
  capture.mask = ImageU8(capture.camera.width, capture.camera.height, 1, 255);
  capture.pose.status = PoseStatus::kGiven;
  capture.pose.camera_from_object = list.camera.camera_from_object;
  capture.light = list.views[index].light;
  capture.verdict = FrameVerdict::kKeyframe;
  return capture;
}

}  // namespace sheen
