// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_set.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/capture/moved_origin.h"
#include "common/datasets/stored_images.h"
#include "common/session/session.h"

namespace sheen {

namespace {

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

RigMotion motion_between(const Session& session, const std::vector<std::uint64_t>& kept) {
  MotionWatch watch;
  for (const std::uint64_t index : kept) {
    const Capture capture = session.read(index);
    if (capture.pose.usable()) watch.look({capture.camera, capture.pose.camera_from_object}, capture.light);
  }
  return watch.motion();
}

/// What a data set's stage.json says, where there is one.
std::optional<StageLayout> stage_in(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "stage.json";
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    return load_stage(file);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: it is not used\n", error.what());
    return std::nullopt;
  }
}

}  // namespace

CaptureSet in_frame_at(const Eigen::Vector3d& origin, CaptureSet captures) {
  if (origin.isZero(0)) return captures;
  for (PosedCamera& camera : captures.cameras) camera = in_frame_at(origin, camera);
  captures.read = [origin, read = std::move(captures.read)](std::size_t i) { return in_frame_at(origin, read(i)); };
  return captures;
}

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
            .cameras = some_cameras(*session, kept),
            .motion = [session, kept] { return motion_between(*session, kept); },
            .stage = {},
            .files = {},
            .image_files = {}};
  }
  StoredImages images = open_stored_images(folder);
  for (const std::string& words : {images.summary, images.warning})
    if (!words.empty()) std::fprintf(stderr, "%s\n", words.c_str());
  return {.size = images.size,
          .damaged = images.account.left_out.size(),
          .read = std::move(images.read),
          .cameras = std::move(images.cameras),
          .motion = [motion = images.motion] { return motion; },
          .stage = stage_in(folder),
          .files = std::move(images.account),
          .image_files = std::move(images.files)};
}

}  // namespace sheen
