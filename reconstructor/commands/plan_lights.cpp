// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/angle.h"
#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/report_file.h"
#include "reconstructor/commands/brdf.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/numerics/light_spacing.h"

namespace sheen {
namespace {

struct PlanArguments {
  std::string brdf = "lambertian", json;
  double distance = 0, tolerance = 16;
};

std::vector<std::string> not_covered(const Brdf& brdf) {
  std::vector<std::string> list{
      "edges of cast shadows: they move with the light, whatever the spacing",
      "saturated pixels: their exposure is not known",
      "the horizon, where a surface turns away from the light: only the last spacing covers it",
      "lights off the plane, light from other surfaces"};
  if (!brdf.closed_form) list.emplace_back("surfaces that the camera sees at more than 80 degrees to their normal");
  return list;
}

/// The closest of each.
LightSpacing closest(const LightSpacing& a, const LightSpacing& b) {
  return {std::min(a.along_line, b.along_line), std::min(a.on_grid, b.on_grid),
          std::min(a.on_grid_with_horizon, b.on_grid_with_horizon)};
}

struct Plan {
  LightSpacing lamp, far;
  double curvature = 0;  ///< B2 z^4 in units of the brightest exposure times z^2
};
Plan plan_for(const ExposureBounds& bounds, const PlanArguments& arguments) {
  if (!(bounds.brightest > 0) || !(bounds.point_curvature > 0))
    throw ConfigError("--brdf " + arguments.brdf + ": no light is reflected to an eye within 80 degrees of the normal");
  const double tolerance = arguments.tolerance / 255;
  return {plan_spacing(bounds, arguments.distance, tolerance), plan_direction_spacing(bounds, tolerance),
          bounds.point_curvature / bounds.brightest};
}

void plan_lights(const PlanArguments& arguments) {
  ReportFile json(arguments.json);
  const Brdf brdf = parse_brdf(arguments.brdf);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<Plan> searched(brdf.channels.size());
  tbb::parallel_for(std::size_t{0}, searched.size(),
                    [&](std::size_t i) { searched[i] = plan_for(search_bounds(*brdf.channels[i]), arguments); });
  const double search_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  Plan plan = searched.front();
  for (const Plan& channel : searched)
    plan = {closest(plan.lamp, channel.lamp), closest(plan.far, channel.far),
            std::max(plan.curvature, channel.curvature)};
  const double found = plan.curvature;
  if (brdf.closed_form) plan = plan_for(*brdf.closed_form, arguments);

  std::printf("lights on a line:  at most %.4g m apart\n", plan.lamp.along_line);
  std::printf("lights on a grid:  at most %.4g m apart\n", plan.lamp.on_grid);
  std::printf("where surfaces turn away from the light: %.4g m\n", plan.lamp.on_grid_with_horizon);
  std::printf("far lights, in latitude and longitude: at most %.4g degrees apart; where surfaces turn away: %.4g\n",
              plan.far.on_grid / kDegree, plan.far.on_grid_with_horizon / kDegree);
  std::printf("for errors of at most %g of 255 grey levels of exposure.\n", arguments.tolerance);
  std::printf(
      "second derivative of the exposure, of the brightest: at most %.5g / z^4 (%s%.5g / z^4 by search, %.0f ms)\n",
      plan.curvature, brdf.closed_form ? "closed form; " : "", found, search_ms);
  std::printf("Not covered:\n");
  const std::vector<std::string> exceptions = not_covered(brdf);
  for (const std::string& what : exceptions) std::printf("- %s\n", what.c_str());
  nlohmann::json report{{"brdf", arguments.brdf},
                        {"distance_m", arguments.distance},
                        {"tolerance_grey_levels", arguments.tolerance},
                        {"spacing_on_line_m", plan.lamp.along_line},
                        {"spacing_on_grid_m", plan.lamp.on_grid},
                        {"spacing_with_horizon_m", plan.lamp.on_grid_with_horizon},
                        {"far_spacing_on_arc_deg", plan.far.along_line / kDegree},
                        {"far_spacing_on_grid_deg", plan.far.on_grid / kDegree},
                        {"far_spacing_with_horizon_deg", plan.far.on_grid_with_horizon / kDegree},
                        {"curvature", plan.curvature},
                        {"searched_curvature", found},
                        {"search_ms", search_ms},
                        {"not_covered", exceptions}};
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_plan_lights_command(Command& program) {
  auto arguments = std::make_shared<PlanArguments>();
  Command command =
      program.subcommand("plan-lights", "How far apart the places of a moving light may be, for an irradiance field.");
  command
      .option("--brdf", arguments->brdf,
              "lambertian, lafortune:K, lafortune:B:K,B:K..., or a file: JSON or a table of the MERL database")
      .show_default();
  command.option("--distance", arguments->distance, "least distance of the scene from the plane, in metres")
      .required()
      .check(number_in(1e-6, 1e6));
  command
      .option("--tolerance", arguments->tolerance,
              "largest error, in grey levels of 255 of which the brightest surface has all")
      .show_default()
      .check(number_in(1e-3, 255));
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { plan_lights(*arguments); });
}

}  // namespace sheen
