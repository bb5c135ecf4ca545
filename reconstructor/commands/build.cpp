// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/datasets/dataset.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/report.h"
#include "reconstructor/scene_config.h"

namespace sheen {
namespace {

struct BuildArguments {
  std::string dataset, mesh, out, config, json;
  int hold_out = -1;
};

void build(const BuildArguments& arguments) {
  SceneConfig config = arguments.config.empty() ? SceneConfig{} : load_scene_config(arguments.config);
  if (arguments.hold_out >= 0) config.surface_light_field.hold_out_every = arguments.hold_out;
  const Dataset dataset = load_dataset(arguments.dataset);
  LoadedMesh loaded = load_mesh(arguments.mesh);
  for (const std::string& warning : loaded.diagnosis.warnings())
    std::fprintf(stderr, "%s: %s\n", arguments.mesh.c_str(), warning.c_str());

  Reconstruction reconstruction(std::move(loaded.mesh), config.surface_light_field);
  for (std::size_t i = 0; i < dataset.views.size(); ++i) {
    const IngestReport report = reconstruction.ingest(read_capture(dataset, i));
    if (report.status == IngestStatus::kRefused)
      std::fprintf(stderr, "%s: not used: %s\n", dataset.views[i].name.c_str(), report.reason.c_str());
  }
  const nlohmann::json report = reconstruction_report(reconstruction);
  if (!arguments.json.empty()) write_json(arguments.json, report);
}

}  // namespace

void add_build_command(CLI::App& app) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* command = app.add_subcommand("build", "Builds a surface light field from posed photographs or a session.");
  command->add_option("dataset", arguments->dataset, "folder with transforms.json, a COLMAP model or a Sheen session")
      ->required();
  command->add_option("--mesh", arguments->mesh, "PLY, OBJ or OFF in the dataset's frame")->required();
  command->add_option("--out", arguments->out, "folder of the model to write");
  command->add_option("--hold-out", arguments->hold_out,
                      "hold out every Nth image where the dataset names no test views; 0 = none");
  command->add_option("--config", arguments->config, "scene file (TOML)");
  command->add_option("--json", arguments->json, "report to write; - for standard output");
  command->callback([arguments] { build(*arguments); });
}

}  // namespace sheen
