// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/report_file.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/numerics/light_spacing.h"

namespace sheen {
namespace {

struct PlanArguments {
  std::string brdf = "lambertian", json;
  double distance = 0, tolerance = 16;
};

constexpr const char* kNotCovered[] = {
    "edges of cast shadows: they move with the light, whatever the spacing",
    "saturated pixels: their exposure is not known",
    "the horizon, where a surface turns away from the light: only the last spacing covers it",
    "lights off the plane, light from other surfaces"};

/// Throws ConfigError.
std::vector<ReflectanceLobe> lobes_of(const std::string& brdf) {
  const auto fail = [&]() -> double {
    throw ConfigError(
        "--brdf takes lambertian, lafortune:K or lafortune:B:K,B:K... (weights B above 0, exponents K 0 or 1 "
        "to 100000), not " +
        brdf);
  };
  if (brdf == "lambertian") return {{}};
  constexpr std::string_view kLafortune = "lafortune:";
  if (!std::string_view(brdf).starts_with(kLafortune)) fail();
  const auto number = [&](std::string_view word) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() ? value : fail();
  };
  std::vector<ReflectanceLobe> lobes;
  for (std::string_view rest = std::string_view(brdf).substr(kLafortune.size());;) {
    const std::string_view lobe = rest.substr(0, rest.find(','));
    const std::size_t colon = lobe.find(':');
    const double weight = colon == std::string_view::npos ? 1 : number(lobe.substr(0, colon)),
                 exponent = number(lobe.substr(colon == std::string_view::npos ? 0 : colon + 1));
    if (!(weight > 0 && weight < 1e9) || !(exponent == 0 || (exponent >= 1 && exponent <= 1e5))) fail();
    lobes.push_back({weight, exponent});
    if (lobe.size() == rest.size()) return lobes;
    rest.remove_prefix(lobe.size() + 1);
  }
}

void plan_lights(const PlanArguments& arguments) {
  ReportFile json(arguments.json);
  const LightSpacing spacing = plan_spacing(lobes_of(arguments.brdf), arguments.distance, arguments.tolerance / 255);
  std::printf("lights on a line:  at most %.4g m apart\n", spacing.along_line);
  std::printf("lights on a grid:  at most %.4g m apart\n", spacing.on_grid);
  std::printf("where surfaces turn away from the light: %.4g m\n", spacing.on_grid_with_horizon);
  std::printf("for errors of at most %g of 255 grey levels of exposure. Not covered:\n", arguments.tolerance);
  for (const char* what : kNotCovered) std::printf("- %s\n", what);
  json.write(nlohmann::json{{"brdf", arguments.brdf},
                            {"distance_m", arguments.distance},
                            {"tolerance_grey_levels", arguments.tolerance},
                            {"spacing_on_line_m", spacing.along_line},
                            {"spacing_on_grid_m", spacing.on_grid},
                            {"spacing_with_horizon_m", spacing.on_grid_with_horizon},
                            {"not_covered", kNotCovered}}
                 .dump(2) +
             "\n");
}

}  // namespace

void add_plan_lights_command(CLI::App& app) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* command = app.add_subcommand(
      "plan-lights", "How far apart the places of a point light on a plane may be, for an irradiance field.");
  command->add_option("--brdf", arguments->brdf, "lambertian, lafortune:K or lafortune:B:K,B:K...")
      ->capture_default_str();
  command->add_option("--distance", arguments->distance, "least distance of the scene from the plane, in metres")
      ->required()
      ->check(number_in(1e-6, 1e6));
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "largest error, in grey levels of 255 of which the brightest surface has all")
      ->capture_default_str()
      ->check(number_in(1e-3, 255));
  command->add_option("--json", arguments->json, "report to write; - for standard output");
  command->callback([arguments] { plan_lights(*arguments); });
}

}  // namespace sheen
