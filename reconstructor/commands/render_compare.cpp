// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/render_compare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_number.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/plain_names.h"
#include "reconstructor/evaluation/held_out.h"

namespace sheen {
namespace {

/// Two pictures of one size.
ImageU8 side_by_side(const ImageU8& left, const ImageU8& right) {
  ImageU8 both(left.width() + right.width(), left.height(), 3);
  for (int y = 0; y < both.height(); ++y) {
    std::copy_n(left.row(y), 3 * left.width(), both.row(y));
    std::copy_n(right.row(y), 3 * right.width(), both.pixel(left.width(), y));
  }
  return both;
}

/// What a model says of a photograph.
const char* part_of(const KnownCapture* known) {
  if (!known) return "not of the model";
  return known->status == IngestStatus::kHeldOut ? "held out" : "built from";
}

}  // namespace

nlohmann::json render_comparison(const std::string& model, const std::string& dataset,
                                 const std::filesystem::path& out) {
  install_stop_signals();
  const SavedModel saved = open_model(model);
  const ModelOrigin origin = origin_of(saved, model);
  check_writable_folder(out);
  const CaptureSet captures = in_frame_at(saved.snapshot->mesh().origin, open_capture_set(dataset));
  make_folder(out);
  const RayPainter painter(saved.snapshot->mesh());
  PlainNames names;
  auto pictures = nlohmann::json::array();
  Progress progress("rendering", captures.size);
  for (std::size_t i = 0; i < captures.size; ++i) {
    if (stop_requested()) throw Error("stopped after " + std::to_string(i) + " photographs");
    Capture capture = captures.read(i);
    progress.update(i + 1);
    if (!capture.pose.usable()) continue;
    const KnownCapture* const known = origin.find(capture);
    if (known && known->camera_from_object) capture.pose.camera_from_object = *known->camera_from_object;
    const HeldOutView view = make_held_out_view(capture, known ? known->exposure_gain : 1, painter);
    const PaintedView painted = painter.paint(*saved.snapshot, view.camera, view.camera_from_object, view.light);
    const std::string name = names.take(capture.name) + ".png";
    make_folder((out / name).parent_path());
    write_png(out / name, side_by_side(view.pixels().truth, to_srgb8(painted.beauty)));
    const double db = score_object(view, *saved.snapshot, painter).psnr_db;
    {
      const ProgressPause pause;
      std::printf("%s: %.2f dB, %s\n", name.c_str(), db, part_of(known));
    }
    pictures.push_back({{"file", name}, {"psnr_db", json_number(db)}, {"photograph", part_of(known)}});
  }
  std::printf("%zu photographs beside their pictures in %s\n", pictures.size(), out.c_str());
  return {{"comparison", pictures}};
}

}  // namespace sheen
