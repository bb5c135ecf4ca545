// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "common/base/report_file.h"
#include "common/camera/camera_file.h"
#include "common/datasets/light_list.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "tracker/calibration/image_set.h"
#include "tracker/commands/lights.h"
#include "tracker/lights/ball_lights.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

struct BallArguments {
  std::vector<fs::path> images;
  fs::path out, camera, json;
  std::string ball;
};

std::optional<BallCircle> parse_ball(const std::string& text) {
  if (text.empty()) return std::nullopt;
  BallCircle ball;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &ball.centre.x(), &ball.centre.y(), &ball.radius, &used) != 3 ||
      used != int(text.size()) || !(ball.radius >= 4 && ball.radius < 1e5) || !(ball.centre.norm() < 1e5))
    throw ConfigError("--ball " + text + " is no place of a ball; write X,Y,RADIUS in pixels, a radius of 4 or more");
  return ball;
}

BallView view_of(const ImageSize& size, const fs::path& file) {
  if (file.empty()) return BallView(size);
  const Camera camera = load_camera(file).camera;
  if (camera.width != size.width || camera.height != size.height)
    throw FileError(file.string(), "is of a camera of " + std::to_string(camera.width) + " x " +
                                       std::to_string(camera.height) + " pixels, the images have " +
                                       std::to_string(size.width) + " x " + std::to_string(size.height));
  return BallView(camera);
}

ImageF linear_light(const fs::path& file) {
  const ImageF rgb = to_linear_rgb(read_image(file));
  ImageF light(rgb.width(), rgb.height(), 1);
  for (std::size_t i = 0; i < light.size(); ++i)
    light.data()[i] = (rgb.data()[3 * i] + rgb.data()[3 * i + 1] + rgb.data()[3 * i + 2]) / 3;
  return light;
}

nlohmann::json report_of(const BallCircle& ball, const BallLights& lights, const ImageSet& images) {
  auto list = nlohmann::json::array();
  for (std::size_t i = 0; i < lights.images.size(); ++i) {
    const auto& [highlight, refusal] = lights.images[i];
    nlohmann::json entry{{"image", images.names[i]}};
    if (highlight) {
      entry["direction"] = {highlight->direction.x(), highlight->direction.y(), highlight->direction.z()};
      entry["uncertainty_deg"] = highlight->uncertainty_deg;
    } else {
      entry["refusal"] = refusal;
    }
    list.push_back(std::move(entry));
  }
  return {{"ball",
           {{"x", ball.centre.x()},
            {"y", ball.centre.y()},
            {"radius", ball.radius},
            {"uncertainty_px", std::sqrt(lights.outline.covariance.trace() / 3)},
            {"visible", lights.outline.visible},
            {"support", lights.outline.support}}},
          {"found", lights.found()},
          {"images", std::move(list)}};
}

void find_lights(const BallArguments& arguments) {
  ReportFile json(arguments.json);
  check_writable(arguments.out);
  const EndOnStop give_up("sheen-tracker: stopped; nothing was written");
  if (arguments.out.extension() != ".lp") throw ConfigError("--out " + arguments.out.string() + " must end in .lp");
  const std::optional<BallCircle> about = parse_ball(arguments.ball);
  const ImageSet images = find_images(arguments.images);
  const BallView view = view_of(images.size, arguments.camera);
  const BallLights lights = lights_of_ball(
      view, images.files.size(), [&](std::size_t i) { return linear_light(images.files[i]); }, about,
      progress_bar("looking at the ball"));

  const BallCircle ball = view.in_image(lights.outline.circle);
  std::printf("ball: x %.2f, y %.2f, radius %.2f pixels (+- %.2f), %.0f %% of its outline in the image\n",
              ball.centre.x(), ball.centre.y(), ball.radius, std::sqrt(lights.outline.covariance.trace() / 3),
              100 * lights.outline.visible);
  std::vector<LitView> views;
  std::vector<double> uncertainties;
  for (std::size_t i = 0; i < lights.images.size(); ++i) {
    const auto& [highlight, refusal] = lights.images[i];
    if (!highlight) {
      std::cerr << "left out: " << images.names[i] << ": " << refusal << ": " << refusal_text(refusal) << '\n';
      continue;
    }
    views.push_back({relative_name(images.files[i], fs::path(arguments.out).parent_path()),
                     {.kind = LightKind::kDirectional, .position = highlight->direction}});
    uncertainties.push_back(highlight->uncertainty_deg);
  }
  write_file(arguments.out, light_list_text(views));
  std::printf("%s: %zu of %zu lights, known to %.2g degrees (median), %.2g (worst)\n", arguments.out.c_str(),
              views.size(), images.files.size(), median(uncertainties), std::ranges::max(uncertainties));
  if (json.wanted()) json.write(report_of(ball, lights, images).dump(2) + "\n");
}

}  // namespace

void add_lights_ball_command(Command& lights) {
  Command command = lights.subcommand("ball", "Directions of far lights, from a chrome ball in the images.");
  const auto a = std::make_shared<BallArguments>();
  command.option("images", a->images, "images of one camera that stands still, one light in each, or folders")
      .required();
  command.option("--out", a->out, "list of lights (.lp) to write, for `build` and `run --source dataset:`").required();
  command.option("--camera", a->camera,
                 "what `calibrate` wrote; without it the camera is taken to be far from the ball");
  command.option("--ball", a->ball,
                 "where the ball is, X,Y,RADIUS in pixels, to a fifth of the radius; else it is searched");
  command.option("--json", a->json, "report to write; - for standard output");
  command.callback([a] { find_lights(*a); });
}

}  // namespace sheen
