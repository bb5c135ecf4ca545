// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "common/color.h"
#include "common/datasets/dataset.h"
#include "common/errors.h"
#include "common/exr.h"
#include "common/files.h"
#include "common/image_io.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/exchange/model_files.h"
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
  make_folder(out);

  const RayPainter painter(model->mesh());
  for (const DatasetView& view : cameras) {
    PaintedView painted = painter.paint(*model, view.camera, view.camera_from_object);
    const std::string name = std::filesystem::path(view.name).stem().string();
    write_png(out / (name + ".png"), to_srgb8(painted.beauty));
    ExrFile file;
    file.parts.push_back({"beauty", {"R", "G", "B"}, painted.beauty, ExrPrecision::kHalf});
    file.parts.push_back({"heuristic", {"Y"}, painted.heuristic, ExrPrecision::kHalf});
    file.parts.push_back(coverage_part(painted));
    write_exr(out / (name + ".exr"), file);
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
