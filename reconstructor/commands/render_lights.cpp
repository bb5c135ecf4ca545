// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/render_lights.h"

#include <cstdio>

#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/light_check.h"
#include "reconstructor/commands/picture_names.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

void render_lights(const std::filesystem::path& model, const std::filesystem::path& list,
                   const std::filesystem::path& out) {
  const SavedModel saved = open_model(model);
  const std::vector<LitView> lights = load_lights(list);
  require_light_kind(*saved.snapshot, lights, model, list);
  check_writable_folder(out);
  make_folder(out);

  std::vector<std::string> views;
  for (const LitView& view : lights) views.push_back(view.name);
  const std::vector<std::filesystem::path> names = picture_names(views);
  const RayPainter painter(saved.snapshot->mesh());
  const PosedCamera& from = saved.snapshot->cameras().front();
  Progress progress("rendering", lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const PaintedView painted = painter.paint(*saved.snapshot, from.camera, from.camera_from_object, lights[i].light);
    const std::string name = (out / names[i]).string();
    make_folder((out / names[i]).parent_path());
    write_png(name + ".png", to_srgb8(painted.beauty));
    ExrFile file;
    file.parts.push_back({"beauty", {"R", "G", "B"}, painted.beauty, ExrPrecision::kHalf});
    write_exr(name + ".exr", file);
    progress.update(i + 1);
  }
  std::printf("%zu pictures rendered to %s\n", lights.size(), out.c_str());
}

}  // namespace sheen
