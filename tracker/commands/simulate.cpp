// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/errors.h"
#include "common/simulation/simulated_rig.h"
#include "tracker/commands/commands.h"

namespace sheen {
namespace {

struct SimulateArguments {
  std::filesystem::path out;
  SimulationOptions rig;
  std::string size = "1024x768";
  bool json = false;
};

void parse_size(const std::string& text, SimulationOptions& rig) {
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &rig.width, &rig.height, &used) != 2 || used != int(text.size()))
    throw ConfigError("--size \"" + text + "\" is no size; write it as 1024x768");
}

void render(SimulateArguments arguments) {
  parse_size(arguments.size, arguments.rig);
  const bool on_terminal = isatty(STDERR_FILENO);
  const auto start = std::chrono::steady_clock::now();
  const CachedRecording result = cached_recording(arguments.rig, arguments.out, [&](int done, int total) {
    if (on_terminal) std::fprintf(stderr, "\rrendering %d of %d frames%s", done, total, done == total ? "\n" : "");
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto frames = result.recording.frames.size();
  if (arguments.json) {
    std::cout << nlohmann::json{{"folder", arguments.out.string()},
                                {"frames", frames},
                                {"rendered", result.rendered},
                                {"seconds", seconds},
                                {"seconds_per_frame", result.rendered ? seconds / double(frames) : 0.0}}
                     .dump(2)
              << '\n';
  } else if (result.rendered) {
    std::printf("%zu frames rendered into %s in %.0f s\n", frames, arguments.out.c_str(), seconds);
  } else {
    std::printf("%s already holds these %zu frames\n", arguments.out.c_str(), frames);
  }
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("simulate", "Render a rig that needs no camera: an object on a tagged stage");
  const auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("--out", arguments->out, "Folder of the recording; kept when it holds the same one already")
      ->required();
  command->add_option("--frames", arguments->rig.frames, "Number of frames")->capture_default_str();
  command->add_option("--size", arguments->size, "Size of a frame, WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--seed", arguments->rig.seed, "Seed of the camera's path and of the noise")
      ->capture_default_str();
  command->add_option("--object", arguments->rig.object, "demo or sphere")->capture_default_str();
  command->add_flag("--truth", arguments->rig.truth, "Also write each frame's linear radiance as OpenEXR");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { render(*arguments); });
}

}  // namespace sheen
