// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/posed_images.h"

#include <cstdio>
#include <memory>
#include <set>

#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/datasets/dataset.h"
#include "common/session/session.h"

namespace sheen {

PosedImages open_posed_images(const std::filesystem::path& folder) {
  if (!Session::exists(folder)) {
    const auto dataset = std::make_shared<Dataset>(load_dataset(folder));
    check_sizes(*dataset);
    for (const std::string& words : {in_words(dataset->account, dataset->root), dataset->warning})
      if (!words.empty()) std::fprintf(stderr, "%s\n", words.c_str());
    return {dataset->views.size(), [dataset](std::size_t i) { return read_capture(*dataset, i); }};
  }
  const auto session = std::make_shared<Session>(Session::open_read_only(folder));
  const std::set<std::uint64_t> withdrawn = session->withdrawn();
  std::vector<std::uint64_t> kept;
  for (std::uint64_t i = 0; i < session->size(); ++i) {
    if (withdrawn.contains(i)) continue;
    try {
      session->check(i);
      kept.push_back(i);
    } catch (const DamagedCapture& error) {
      std::fprintf(stderr, "left out: %s\n", error.what());
    }
  }
  return {kept.size(), [session, kept](std::size_t i) { return session->read(kept[i]); }};
}

std::map<std::string, PosedCamera> cameras_by_name(const PosedImages& images) {
  Progress progress("reading poses", images.size);
  std::map<std::string, PosedCamera> cameras;
  for (std::size_t i = 0; i < images.size; ++i) {
    const Capture capture = images.read(i);
    if (capture.pose.usable()) cameras[capture.name] = {capture.camera, capture.pose.camera_from_object};
    progress.update(i + 1);
  }
  return cameras;
}

std::vector<RegistrationImage> some_images(const PosedImages& images, std::size_t most) {
  std::vector<RegistrationImage> chosen;
  const std::size_t stride = std::max<std::size_t>(1, (images.size + most - 1) / most);
  Progress progress("reading images", images.size / stride);
  for (std::size_t i = 0; i < images.size; i += stride) {
    const Capture capture = images.read(i);
    if (capture.pose.usable()) chosen.push_back(registration_image(capture));
    progress.update(chosen.size());
  }
  return chosen;
}

}  // namespace sheen
