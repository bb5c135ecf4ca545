// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/datasets/dataset.h"
#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "common/simulation/simulated_rig.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr int kRendererVersion = 3;  // counts up when the same options give other pixels
constexpr int kHoldOutEvery = 8;
constexpr double kExposureSeconds = 0.001;
constexpr const char* kLightTable = "lights.lp";

/// Of a path that is a file.
std::string content_of_path(const std::string& path) {
  return path.ends_with(".lp") ? ' ' + content_hash(read_file(path)) : "";
}

std::string parameters_hash(const SimulationOptions& o) {
  std::ostringstream text;
  text << kRendererVersion << ' ' << o.object << ' ' << o.frames << ' ' << o.width << 'x' << o.height << ' ' << o.seed
       << ' ' << o.truth << ' ' << o.frame_rate_hz << ' ' << o.bake.sky_directions << ' ' << o.bake.bounce_directions
       << ' ' << o.bake.bounces << ' ' << o.bake.area_light_samples << ' ' << o.bake.stage_cell_m;
  if (!o.light_path.empty() || o.still_camera)
    text << " light " << o.light_path << (o.still_camera ? " still" : "") << content_of_path(o.light_path);
  return content_hash(text.str());
}

std::string frame_name(std::size_t index) {
  return format("frame_%04zu", index);
}

/// The shortest text that reads back as the same number, with a point or an exponent, as JSON and TOML floats have.
std::string toml_float(double value) {
  return nlohmann::json(value).dump();
}

/// Configuration with which `sheen-tracker run` tracks this rig through its camera server.
std::string tracker_config(const Camera& c, bool still_camera, bool lamp) {
  std::ostringstream toml;
  toml << "# Written with a simulated rig: its exact intrinsics and the stage it stands on.\n"
       << "[camera]\nwidth = " << c.width << "\nheight = " << c.height << "\nfx = " << toml_float(c.fx)
       << "\nfy = " << toml_float(c.fy) << "\ncx = " << toml_float(c.cx) << "\ncy = " << toml_float(c.cy)
       << "\nlens = \"opencv\"\ndistortion = [";
  for (std::size_t i = 0; i < c.distortion.size(); ++i) toml << (i ? ", " : "") << toml_float(c.distortion[i]);
  toml << "]\n";
  if (still_camera) toml << "still = true\n";
  toml << "\n[stage]\nfile = \"stage.json\"\n\n[source]\nuri = \"aravis:127.0.0.1\"\n";
  if (lamp) toml << "\n[light]\ntable = \"" << kLightTable << "\"\nindex = \"sent.csv\"  # serve with --log sent.csv\n";
  return toml.str();
}

/// Where the lamp is at each frame, in the frame of the object.
std::string light_table(const std::vector<LightState>& lights) {
  std::vector<LitView> views;
  for (const LightState& light : lights) views.push_back({frame_name(views.size()), light});
  return light_list_text(views);
}

void write_frame(const SimulatedFrame& frame, const fs::path& folder, const std::string& name, bool truth) {
  write_file(folder / "frames" / (name + ".raw"),
             {reinterpret_cast<const char*>(frame.raw.bytes.data()), frame.raw.bytes.size()});
  write_png(folder / "images" / (name + ".png"), to_srgb8(to_linear_rgb(frame.raw)));
  write_png(folder / "masks" / (name + ".png"), frame.mask);
  if (truth)
    write_exr(folder / "truth" / (name + ".exr"), ExrFile{.parts = {{.name = "radiance",
                                                                     .channels = {"R", "G", "B"},
                                                                     .image = frame.radiance,
                                                                     .precision = ExrPrecision::kHalf}},
                                                          .attributes = {}});
}

/// Whether every file that `recording` promises is there and whole.
bool is_complete(const RigRecording& recording) {
  const auto bytes = std::uintmax_t(recording.camera.width) * recording.camera.height;
  std::error_code error;
  for (const RigFrame& frame : recording.frames)
    if (fs::file_size(frame.raw_file, error) != bytes || error) return false;
  for (const char* file : {"mesh.ply", "stage.json", "rig.toml", "transforms.json"})
    if (!fs::is_regular_file(recording.folder / file, error)) return false;
  return true;
}

}  // namespace

RigRecording planned_recording(const SimulatedRig& rig, const fs::path& folder) {
  RigRecording recording{.folder = folder,
                         .camera = rig.camera(),
                         .frame_rate_hz = rig.options().frame_rate_hz,
                         .exposure = {.exposure_s = kExposureSeconds, .locked = true},
                         .parameters_hash = parameters_hash(rig.options())};
  for (std::size_t i = 0; i < rig.size(); ++i)
    recording.frames.push_back({.raw_file = folder / "frames" / (frame_name(i) + ".raw"),
                                .camera_from_object = rig.path()[i].camera_from_object,
                                .blur_px = rig.blur_px(i)});
  return recording;
}

RigRecording write_recording(const SimulatedRig& rig, const fs::path& folder, const RenderProgress& progress) {
  make_folder(folder);
  std::error_code ignored;
  fs::remove(folder / "rig.json", ignored);  // from here on the folder is incomplete
  for (const char* sub : {"frames", "images", "masks"}) make_folder(folder / sub);
  if (rig.options().truth) make_folder(folder / "truth");
  save_ply(rig.object().mesh, folder / "mesh.ply");
  save_stage(rig.stage(), folder / "stage.json");
  write_file(folder / "rig.toml", tracker_config(rig.camera(), rig.options().still_camera, !rig.lights().empty()));
  if (!rig.lights().empty()) write_file(folder / kLightTable, light_table(rig.lights()));

  // In order, for who looks on; each is rendered by whoever is free.
  std::atomic<std::size_t> next = 0;
  std::mutex reporting;
  std::vector<bool> there(rig.size());
  std::size_t done = 0;
  tbb::parallel_for(std::size_t(0), rig.size(), [&](std::size_t) {
    const std::size_t i = next++;
    write_frame(rig.frame(i), folder, frame_name(i), rig.options().truth);
    const std::lock_guard lock(reporting);
    there[i] = true;
    while (done < there.size() && there[done]) ++done;
    if (progress) progress(static_cast<int>(done), static_cast<int>(rig.size()));
  });

  // All of a still camera's picture counts, as a model of one camera asks.
  const auto mask_of = [&](std::size_t i) -> std::optional<fs::path> {
    if (rig.options().still_camera) return std::nullopt;
    return folder / "masks" / (frame_name(i) + ".png");
  };
  const RigRecording recording = planned_recording(rig, folder);
  std::vector<DatasetView> views;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    if (recording.frames[i].blur_px > 0) continue;
    const std::string name = "images/" + frame_name(i) + ".png";
    views.push_back(
        {.name = name,
         .image_path = folder / name,
         .mask_path = mask_of(i),
         .camera = rig.camera(),
         .camera_from_object = recording.frames[i].camera_from_object,
         .light = rig.lights().empty() ? LightState{} : rig.lights()[i],
         .purpose = views.size() % kHoldOutEvery == kHoldOutEvery / 2 ? Purpose::kHeldOut : Purpose::kTraining,
         .exposure_s = kExposureSeconds});
  }
  write_transforms(folder / "transforms.json", views);
  save_rig_recording(recording);
  return recording;
}

std::optional<RigRecording> finished_recording(const SimulationOptions& options, const fs::path& folder) {
  if (!fs::exists(folder / "rig.json")) return std::nullopt;
  RigRecording recording = load_rig_recording(folder);
  if (recording.parameters_hash != parameters_hash(options) || !is_complete(recording)) return std::nullopt;
  return recording;
}

CachedRecording cached_recording(const SimulationOptions& options, const fs::path& folder,
                                 const RenderProgress& progress) {
  if (auto finished = finished_recording(options, folder)) return {*std::move(finished), false};
  return {write_recording(SimulatedRig(options), folder, progress), true};
}

}  // namespace sheen
