// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_set.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>
#include <vector>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/datasets/dataset.h"
#include "common/datasets/light_list.h"
#include "common/session/session.h"

namespace sheen {

namespace {

std::vector<PosedCamera> cameras_of(const Dataset& dataset) {
  std::vector<PosedCamera> cameras;
  for (const DatasetView& view : dataset.views) cameras.push_back({view.camera, view.camera_from_object});
  return cameras;
}

/// Of captures spread over the session: each is decoded for it.
std::vector<PosedCamera> some_cameras(const Session& session, const std::vector<std::uint64_t>& kept) {
  constexpr std::size_t kSome = 8;
  std::vector<PosedCamera> cameras;
  for (std::size_t i = 0; i < kept.size(); i += std::max<std::size_t>(1, kept.size() / kSome)) {
    try {
      const Capture capture = session.read(kept[i]);
      if (capture.pose.usable()) cameras.push_back({capture.camera, capture.pose.camera_from_object});
    } catch (const Error&) {  // told when it is its turn
    }
  }
  return cameras;
}

}  // namespace

CaptureSet open_capture_set(const std::filesystem::path& folder) {
  if (Session::exists(folder)) {
    auto session = std::make_shared<Session>(Session::open_read_only(folder));
    const std::set<std::uint64_t> withdrawn = session->withdrawn();
    std::vector<std::uint64_t> kept;
    std::size_t damaged = 0;
    for (std::uint64_t i = 0; i < session->size(); ++i) {
      if (withdrawn.contains(i)) continue;
      try {
        session->check(i);
        kept.push_back(i);
      } catch (const DamagedCapture& error) {
        log_error("session", std::string("left out: ") + error.what());
        ++damaged;
      }
    }
    const auto read = [session, kept](std::size_t i) { return session->read(kept[i]); };
    return {.size = kept.size(),
            .withdrawn = withdrawn.size(),
            .damaged = damaged,
            .read = read,
            .cameras = some_cameras(*session, kept)};
  }
  if (folder.extension() == ".lp") {
    auto list = std::make_shared<LightList>(load_light_list(folder));
    return {.size = list->views.size(),
            .read = [list](std::size_t i) { return read_capture(*list, i); },
            .cameras = {list->camera}};
  }
  auto dataset = std::make_shared<Dataset>(load_dataset(folder));
  if (!dataset->warning.empty()) std::fprintf(stderr, "%s\n", dataset->warning.c_str());
  return {.size = dataset->views.size(),
          .read = [dataset](std::size_t i) { return read_capture(*dataset, i); },
          .cameras = cameras_of(*dataset)};
}

}  // namespace sheen
