// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/render_lights.h"

#include <nlohmann/json.hpp>
#include <span>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/capture/moved_origin.h"
#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/light_check.h"
#include "reconstructor/commands/luminaire_file.h"
#include "reconstructor/commands/picture_layers.h"
#include "reconstructor/commands/picture_names.h"
#include "reconstructor/render/guess_marks.h"
#include "reconstructor/render/luminaires.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

std::vector<LitPicture> in_each(const std::vector<LitView>& views) {
  std::vector<LitPicture> pictures;
  for (const LitView& view : views) pictures.push_back({view.name, {view.light}});
  return pictures;
}

std::vector<LitPicture> along(const std::vector<LitView>& keys, int frames, const std::string& list) {
  if (keys.size() < 2) throw FileError(list, "has one light: a light path needs two or more");
  std::vector<LightState> lights;
  for (const LitView& key : keys) lights.push_back(key.light);
  std::vector<LitPicture> pictures;
  for (const LightState& light : light_path(lights, frames)) {
    if (!(light.position.norm() > 1e-9)) throw FileError(list, "its path goes through the object");
    pictures.push_back({format("frame_%05zu", pictures.size() + 1), {light}});
  }
  return pictures;
}

std::vector<LitPicture> pictures_of(const ModelSnapshot& snapshot, const std::filesystem::path& model,
                                    const LightRequest& request) {
  if (!request.list.empty() || !request.path.empty()) {
    const std::string& list = request.list.empty() ? request.path : request.list;
    std::vector<LitView> views = load_lights(list);
    for (LitView& view : views) view.light = in_frame_at(snapshot.mesh().origin, view.light);
    require_light_kind(snapshot, views, model, list);
    return request.list.empty() ? along(views, request.frames, list) : in_each(views);
  }
  const std::string& file = request.luminaires.empty() ? request.environment : request.luminaires;
  const std::vector<LightState> known = snapshot.lights();
  if (known.empty())
    throw ConfigError(model.string() + " cannot be lit by " + file +
                      ": only pictures of an irradiance field can be added up");
  if (!request.luminaires.empty()) return load_luminaires(request.luminaires, known);
  return {load_environment(request.environment, known)};
}

}  // namespace

void render_lights(const std::filesystem::path& model, const LightRequest& request, const PictureExtras& extras,
                   const std::filesystem::path& out, ReportFile& json) {
  install_stop_signals();
  const SavedModel saved = open_model(model);
  const std::vector<LitPicture> pictures = pictures_of(*saved.snapshot, model, request);
  const PictureLayers layers(extras.layers, saved.snapshot, model.string());
  const RayPainter painter(saved.snapshot->mesh());
  const PosedCamera& from = saved.snapshot->cameras().front();
  const auto paint = [&](const LitPicture& picture) {
    const std::vector<LightState>& lights = picture.lights;
    return painter.paint(*saved.snapshot, from.camera, from.camera_from_object, lights.front(),
                         {lights.begin() + 1, lights.end()});
  };
  const auto shown = [&](const PaintedView& painted) {
    ImageU8 png = to_srgb8(painted.beauty);
    if (extras.marked) mark_guesses(painted, png);
    return png;
  };
  if (is_film(out)) {
    const nlohmann::json video =
        write_film(out, extras.film, pictures.size(), [&](std::size_t i) { return shown(paint(pictures[i])); });
    return json.write(nlohmann::json{{"video", video}}.dump(2) + "\n");
  }
  check_writable_folder(out);
  make_folder(out);

  std::vector<std::string> views;
  for (const LitPicture& picture : pictures) views.push_back(picture.name);
  const std::vector<std::filesystem::path> names = picture_names(views);
  auto written = nlohmann::json::array();
  Progress progress("rendering", pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (stop_requested()) throw Error("stopped after " + std::to_string(i) + " pictures");
    const PaintedView painted = paint(pictures[i]);
    const std::string name = (out / names[i]).string();
    make_folder((out / names[i]).parent_path());
    write_png(name + ".png", shown(painted));
    ExrFile file;
    file.parts.push_back({"beauty", {"R", "G", "B"}, painted.beauty, ExrPrecision::kHalf});
    layers.add(painter, from, pictures[i].lights.front(), file);
    write_exr(name + ".exr", file);
    written.push_back({{"file", names[i].string()}});
    progress.update(i + 1);
  }
  std::printf("%zu pictures rendered to %s\n", pictures.size(), out.c_str());
  json.write(nlohmann::json{{"pictures", written}}.dump(2) + "\n");
}

}  // namespace sheen
