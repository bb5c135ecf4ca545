// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/report_file.h"
#include "common/datasets/light_list.h"
#include "common/geometry/mesh_io.h"
#include "tracker/calibration/posed_images.h"
#include "tracker/commands/lights.h"
#include "tracker/lights/shadow_file.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr double kMuchNoise = 2;

struct ShadowsArguments {
  fs::path pairs, images, mesh, out, json;
};

using Pairs = std::vector<std::vector<ShadowPair>>;

/// By the image's name, or by that of its file alone.
const PosedCamera& view_of(const std::map<std::string, PosedCamera>& views, const std::string& image,
                           const fs::path& images) {
  if (const auto exact = views.find(image); exact != views.end()) return exact->second;
  const PosedCamera* found = nullptr;
  for (const auto& [name, view] : views) {
    if (fs::path(name).filename() != image) continue;
    if (found) throw ConfigError(images.string() + ": several images are called \"" + image + "\"; give the path");
    found = &view;
  }
  if (!found) throw ConfigError(images.string() + ": has no image \"" + image + "\" with a pose");
  return *found;
}

Pairs pairs_of(const ShadowFile& file, const ShadowsArguments& arguments) {
  Pairs pairs;
  if (!file.any_pixels()) {
    for (const ClickedLight& light : file.lights) pairs.push_back(pairs_in_space(light, file, nullptr, nullptr));
    return pairs;
  }
  if (arguments.images.empty() || arguments.mesh.empty())
    throw ConfigError(arguments.pairs.string() +
                      ": has pixels; name the data set or session of its images (--images) and the mesh (--mesh)");
  const auto views = cameras_by_name(open_posed_images(arguments.images));
  const Mesh mesh = load_mesh(arguments.mesh).mesh;
  require_no_origin(arguments.mesh, mesh);
  for (const ClickedLight& light : file.lights)
    pairs.push_back(pairs_in_space(light, file, &view_of(views, light.image, arguments.images), &mesh));
  return pairs;
}

/// One list has lights of one kind: directional where one of them is.
std::vector<ShadowLight> fit_all(const ShadowFile& file, const Pairs& pairs, bool known) {
  std::vector<ShadowLight> lights;
  for (const bool directional : {false, true}) {
    lights.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) try {
        lights.push_back(light_of_shadows(pairs[i], known, directional));
      } catch (const Error& error) {
        throw Error(file.lights[i].image + ": " + error.what());
      }
    const auto far =
        std::count_if(lights.begin(), lights.end(), [](const auto& l) { return !l.why_directional.empty(); });
    if (far == 0 || far == std::ssize(lights)) break;
    for (std::size_t i = 0; i < lights.size(); ++i)
      if (!lights[i].why_directional.empty())
        std::cerr << "all lights are written as directions, because " << file.lights[i].image
                  << " has no known distance: " << lights[i].why_directional << '\n';
  }
  return lights;
}

std::string text_of(const std::string& image, const ShadowLight& found) {
  const Eigen::Vector3d& at = found.light.position;
  std::string text = image + ": ";
  if (found.why_directional.empty()) {
    text += format("a lamp at %.4f %.4f %.4f m, +- %.2g mm", at.x(), at.y(), at.z(),
                   1e3 * std::sqrt(found.covariance.trace()));
  } else {
    text += format("far away, towards %.4f %.4f %.4f", at.x(), at.y(), at.z());
  }
  text += format("; direction +- %.2g degrees; %zu pairs, residual %.2g mm", found.direction_uncertainty_deg,
                 found.residuals.size(), 1e3 * found.rms);
  return found.why_directional.empty() ? text : text + "\n  directional: " + found.why_directional;
}

nlohmann::json report_of(const std::string& image, const ShadowLight& found) {
  const auto vector = [](const Eigen::Vector3d& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
  nlohmann::json report{{"image", image},
                        {"direction", vector(found.direction)},
                        {"direction_uncertainty_deg", found.direction_uncertainty_deg},
                        {"inverse_distance", found.inverse_distance},
                        {"inverse_distance_uncertainty", found.inverse_distance_uncertainty},
                        {"seen_from", vector(found.centre)},
                        {"residuals_m", found.residuals},
                        {"rms_m", found.rms},
                        {"noise", found.noise},
                        {"left_out", found.outliers}};
  if (found.why_directional.empty()) {
    report["position"] = vector(found.light.position);
    report["position_uncertainty_m"] = std::sqrt(found.covariance.trace());
  } else {
    report["directional_because"] = found.why_directional;
  }
  return report;
}

void find_lights(const ShadowsArguments& arguments) {
  ReportFile json(arguments.json);
  check_writable(arguments.out);
  const EndOnStop give_up("sheen-tracker: stopped; nothing was written");
  if (arguments.out.extension() != ".lp") throw ConfigError("--out " + arguments.out.string() + " must end in .lp");
  const ShadowFile file = load_shadow_file(arguments.pairs);
  const bool known = file.any_pixels() ? file.pixel_uncertainty_px.has_value() : file.uncertainty_m.has_value();
  const std::vector<ShadowLight> lights = fit_all(file, pairs_of(file, arguments), known);
  std::vector<LitView> views;
  auto report = nlohmann::json::array();
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::string& image = file.lights[i].image;
    std::cout << text_of(image, lights[i]) << '\n';
    for (const std::size_t pair : lights[i].outliers)
      std::cerr << "warning: " << image
                << format(": pair %zu is %.3g mm from where the others have it and was left out; click it again\n",
                          pair + 1, 1e3 * lights[i].residuals[pair]);
    if (known && lights[i].noise > kMuchNoise)
      std::cerr << "warning: " << image
                << format(": residuals are %.1f times what the file's uncertainties say\n", lights[i].noise);
    views.push_back({image, lights[i].light});
    report.push_back(report_of(image, lights[i]));
  }
  write_file(arguments.out, light_list_text(views));
  if (json.wanted()) json.write(nlohmann::json{{"lights", report}}.dump(2) + "\n");
}

}  // namespace

void add_lights_shadows_command(Command& lights) {
  Command command =
      lights.subcommand("shadows", "Places of lights, from points of an object and where their shadows fall.");
  const auto a = std::make_shared<ShadowsArguments>();
  command.option("pairs", a->pairs, "JSON of shadow points and object points (see the user guide)").required();
  command.option("--images", a->images, "data set or session of the images, where the points are pixels");
  command.option("--mesh", a->mesh, "PLY, OBJ or OFF in its frame, on which the pixels' points are");
  command.option("--out", a->out, "list of lights (.lp) to write").required();
  command.option("--json", a->json, "report to write; - for standard output");
  command.callback([a] { find_lights(*a); });
}

}  // namespace sheen
