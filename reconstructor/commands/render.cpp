// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/datasets/dataset.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/picture_names.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

struct RenderArguments {
  std::string model, cameras, out;
};

/// Grey picture of one channel, 8 bit.
ExrPart coverage_part(const PaintedView& view) {
  ImageF coverage(view.coverage.width(), view.coverage.height(), 1);
  for (std::size_t i = 0; i < coverage.size(); ++i) coverage.data()[i] = view.coverage.data()[i] / 255.0f;
  return {"coverage", {"Y"}, std::move(coverage), ExrPrecision::kHalf};
}

void render(const RenderArguments& arguments) {
  const std::shared_ptr<const SurfaceLightFieldSnapshot> model = load_model(arguments.model);
  const std::vector<DatasetView> cameras = load_cameras(arguments.cameras);
  const std::filesystem::path out = arguments.out;
  check_writable_folder(out);
  make_folder(out);

  std::vector<std::string> views;
  for (const DatasetView& view : cameras) views.push_back(view.name);
  const std::vector<std::filesystem::path> names = picture_names(views);
  const RayPainter painter(model->mesh());
  Progress progress("rendering", cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    PaintedView painted = painter.paint(*model, cameras[i].camera, cameras[i].camera_from_object);
    const std::string name = (out / names[i]).string();
    make_folder((out / names[i]).parent_path());
    write_png(name + ".png", to_srgb8(painted.beauty));
    ExrFile file;
    file.parts.push_back({"beauty", {"R", "G", "B"}, painted.beauty, ExrPrecision::kHalf});
    file.parts.push_back({"heuristic", {"Y"}, painted.heuristic, ExrPrecision::kHalf});
    file.parts.push_back(coverage_part(painted));
    write_exr(name + ".exr", file);
    progress.update(i + 1);
  }
  std::printf("%zu views rendered to %s\n", cameras.size(), out.string().c_str());
}

}  // namespace

void add_render_command(CLI::App& app) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command =
      app.add_subcommand("render", "Renders a saved model from given cameras: linear EXR and PNG a view.");
  command->add_option("model", arguments->model, "folder of a saved model")->required();
  command->add_option("--cameras", arguments->cameras, "transforms.json with the cameras to render")->required();
  command->add_option("--out", arguments->out, "folder for the pictures")->required();
  command->callback([arguments] { render(*arguments); });
}

}  // namespace sheen
