// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/quantity.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/render/gl/opening_view.h"
#include "reconstructor/render/gl/viewer_window.h"

namespace sheen {
namespace {

struct ViewArguments {
  std::string model, screenshot, mode = "light-field", size = "1280x800";
  std::vector<double> eye;
  bool reasons = false, states = false;
};

void view(const ViewArguments& arguments) {
  const auto [width, height] = parse_image_size("--size", arguments.size, 64);
  const std::optional<ViewMode> mode = view_mode_from(arguments.mode);
  if (!mode) throw ConfigError("--mode: '" + arguments.mode + "' is not one of light-field, heuristic, split, camera");
  const bool picture_only = !arguments.screenshot.empty();

  ViewerState state;
  const SavedModel saved = open_model(arguments.model);
  state.snapshot = saved.snapshot;
  ViewerWindow window(*saved.kind, {.width = width, .height = height, .visible = !picture_only});
  ViewControls& controls = window.controls();
  controls.mode = *mode;
  controls.reasons = arguments.reasons;
  controls.states = arguments.states;
  controls.frame(state.snapshot->shared_mesh());
  const Eigen::Vector3d centre = bounding_sphere(state.snapshot->mesh()).centre;
  if (const auto opening = opening_view(state.snapshot->cameras(), centre)) {
    controls.orbit.set_up(opening->up);
    controls.orbit.look_from(opening->direction);
  }
  if (!arguments.eye.empty()) controls.orbit.place({arguments.eye[0], arguments.eye[1], arguments.eye[2]});

  if (picture_only) {
    write_png(arguments.screenshot, window.draw_once(state));
    return;
  }
  ViewerFeed feed;
  feed.publish(std::move(state));
  window.run(feed, {});
}

}  // namespace

void add_view_command(CLI::App& app) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command = app.add_subcommand("view", "Shows a saved model in a window; H lists the keys.");
  command->add_option("model", arguments->model, "saved model: a file or a folder")->required();
  command->add_option("--screenshot", arguments->screenshot, "PNG to write instead of opening a window");
  command->add_option("--mode", arguments->mode, "light-field, heuristic, split or camera")->capture_default_str();
  command->add_flag("--reasons", arguments->reasons, "colour where images are needed by the reason");
  command->add_flag("--states", arguments->states, "tint what is imputed or unseen");
  command->add_option("--size", arguments->size, "size of the window or the screenshot, pixels")->capture_default_str();
  command->add_option("--eye", arguments->eye, "where to look from: x,y,z in the model's frame, metres")
      ->check(number_in(-1e6, 1e6))
      ->delimiter(',')
      ->expected(3);
  command->callback([arguments] { view(*arguments); });
}

}  // namespace sheen
