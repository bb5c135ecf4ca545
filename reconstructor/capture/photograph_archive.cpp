// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/photograph_archive.h"

#include <algorithm>
#include <utility>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/capture/moved_origin.h"
#include "common/datasets/stored_images.h"
#include "common/image/webp.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

Camera camera_of(const Photograph& photograph) {
  Camera camera = photograph.camera;
  camera.cx -= photograph.left;
  camera.cy -= photograph.top;
  camera.width = photograph.pixels.width();
  camera.height = photograph.pixels.height();
  return camera;
}

/// What a cut-out of that size has of a mask, which is white everywhere where it is empty.
std::string cut_mask(const ImageU8& mask, int left, int top, const Camera& cut_out) {
  ImageU8 cut(cut_out.width, cut_out.height, 3, 255);
  for (int y = 0; y < cut.height() && !mask.empty(); ++y)
    for (int x = 0; x < cut.width(); ++x) std::fill_n(cut.pixel(x, y), 3, mask.at(left + x, top + y) ? 255 : 0);
  return encode_webp_lossless(cut);
}

}  // namespace

PhotographArchive::PhotographArchive(const CaptureSet& captures, std::shared_ptr<const Mesh> mesh, int every)
    : captures_(captures), mesh_(std::move(mesh)) {
  PhotographCutter cutter(*mesh_);
  bool masked = false, exposures_known = true;
  double first_exposure = 0;
  for (std::size_t i = 0; i < captures_.size; ++i) {
    const Capture capture = captures_.read(i);
    if (!capture.pose.usable()) continue;
    const double exposure = exposure_product(capture);
    if (frames_.empty()) first_exposure = exposure;
    const float gain = exposure > 0 && first_exposure > 0 ? static_cast<float>(exposure / first_exposure) : 1;
    const std::optional<Photograph> photograph = cutter.cut(in_frame_at(mesh_->origin, capture), gain);
    if (!photograph) continue;
    coding_.add(*photograph);
    const ImageU8 mask = usable_pixels(capture);
    const Camera camera = camera_of(*photograph);
    masked = masked || !mask.empty();
    exposures_known = exposures_known && (exposure > 0 || capture.exposure.locked);
    frames_.push_back({.capture = i,
                       .source = capture.source_session,
                       .view = {.name = format("images/%04zu.webp", i + 1),
                                .image_path = {},
                                .mask_path = {},
                                .camera = camera,
                                .camera_from_object = capture.pose.camera_from_object,
                                .light = capture.light,
                                .purpose = is_held_out(capture, every) ? Purpose::kHeldOut : Purpose::kTraining,
                                .exposure_s = {}},
                       .mask = mask.empty() ? "" : cut_mask(mask, photograph->left, photograph->top, camera),
                       .gain = gain});
  }
  for (Frame& frame : frames_) {
    frame.view.exposure_locked = exposures_known;
    if (masked && frame.mask.empty()) frame.mask = cut_mask({}, 0, 0, frame.view.camera);
  }
}

bool PhotographArchive::holds_out_any() const {
  return std::any_of(frames_.begin(), frames_.end(),
                     [](const Frame& frame) { return frame.view.purpose == Purpose::kHeldOut; });
}

std::vector<DatasetView> PhotographArchive::views(const fs::path& folder) const {
  std::vector<DatasetView> views;
  for (const Frame& frame : frames_) {
    DatasetView& view = views.emplace_back(frame.view);
    view.image_path = folder / view.name;
    if (!frame.mask.empty()) view.mask_path = folder / "masks" / view.image_path.filename();
  }
  return views;
}

std::uintmax_t PhotographArchive::write(const fs::path& folder, int quality) const {
  make_folder(folder / "images");
  const std::vector<DatasetView> views = this->views(folder);
  const std::vector<std::string> pictures = coding_.coded(quality);
  const fs::path transforms = folder / "transforms.json";
  const std::string description = transforms_text(transforms, views);
  std::uintmax_t bytes = description.size();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    write_file(views[i].image_path, pictures[i]);
    bytes += pictures[i].size() + frames_[i].mask.size();
    if (!views[i].mask_path) continue;
    make_folder(views[i].mask_path->parent_path());
    write_file(*views[i].mask_path, frames_[i].mask);
  }
  write_file(transforms, description);
  return bytes;
}

int PhotographArchive::quality_within(std::uintmax_t bytes) const {
  std::uintmax_t beside = transforms_text("small/transforms.json", views("small")).size();
  for (const Frame& frame : frames_) beside += frame.mask.size();
  return coding_.quality_within(bytes > beside ? static_cast<std::size_t>(bytes - beside) : 0);
}

Capture PhotographArchive::read(std::size_t frame) const {
  Capture capture = in_frame_at(mesh_->origin, captures_.read(frames_[frame].capture));
  capture.purpose = frames_[frame].view.purpose;
  return capture;
}

double PhotographArchive::psnr_db(const ModelSettings& settings) const {
  return psnr_db(settings, [&](std::size_t frame) { return read(frame); });
}

double PhotographArchive::psnr_db(const ModelSettings& settings, const fs::path& archive) const {
  const StoredImages coded = open_stored_images(archive);
  return psnr_db(settings, [&](std::size_t frame) {
    if (frames_[frame].view.purpose == Purpose::kHeldOut) return levelled(read(frame), frames_[frame].gain);
    Capture capture = in_frame_at(mesh_->origin, coded.read(frame));
    capture.source_session = frames_[frame].source;
    return capture;
  });
}

double PhotographArchive::psnr_db(const ModelSettings& settings,
                                  const std::function<Capture(std::size_t)>& read) const {
  Reconstruction reconstruction(*mesh_, settings);
  reconstruction.expect_at_most(frames_.size());
  for (std::size_t frame = 0; frame < frames_.size(); ++frame) reconstruction.ingest(read(frame));
  reconstruction.finish();
  return reconstruction.judge().model.psnr_db;
}

}  // namespace sheen
