// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/simulated_rig.h"

#include <algorithm>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/simulation/light_path.h"
#include "common/simulation/procedural_noise.h"

namespace sheen {
namespace {

constexpr int kBlurSteps = 9;  // poses that a moving frame averages; odd, for one in the middle
constexpr double kMeterQuantile = 0.9975;
constexpr float kDimmed = 0.1f;       // the studio beside a lamp
constexpr float kLampPower = 2;       // irradiance at one metre: about as bright at the object as the studio
constexpr double kMeterLevel = 0.97;  // of white, at that quantile of the object's pixels

PathTracer make_tracer(const SimulationOptions& options, const StageLayout& stage) {
  return PathTracer({make_test_object(options.object), StageSurface(stage), make_studio()}, options.bake);
}

Camera checked_camera(const SimulationOptions& options) {
  if (options.width < 16 || options.height < 16 || options.width > 8192 || options.height > 8192)
    throw ConfigError("simulation: the size must be 16x16 to 8192x8192 pixels");
  if (options.width % 2 != 0 || options.height % 2 != 0)
    throw ConfigError("simulation: width and height must be even, as a Bayer sensor's are");
  Camera camera = simulated_camera(options.width, options.height);
  if (options.still_camera) camera.distortion = {};
  return camera;
}

std::vector<CameraStation> path_of(const SimulationOptions& options, const Camera& camera) {
  std::vector<CameraStation> path = camera_path({.frames = options.frames, .seed = options.seed}, camera);
  if (options.still_camera) path.assign(path.size(), CameraStation{path[path.size() / 2].camera_from_object});
  return path;
}

}  // namespace

SimulatedRig::SimulatedRig(const SimulationOptions& options)
    : options_(options),
      stage_(make_stage({})),
      tracer_(make_tracer(options, stage_)),
      lens_(checked_camera(options)),
      path_(path_of(options, lens_.camera())),
      lights_(options.light_path.empty() ? std::vector<LightState>() : light_path(options.light_path, options.frames)),
      white_level_(meter()) {}

/// White level at which all but the hottest cores of highlights stay below it, from small views along the path.
double SimulatedRig::meter() const {
  constexpr int kViews = 12;
  const LensRays small(simulated_camera(256, 192));
  std::vector<float> brightest;
  for (int i = 0; i < kViews; ++i) {
    const std::size_t index = path_.size() * i / kViews;
    const RenderedView view = tracer_.render(small, path_[index].camera_from_object,
                                             lit({.object_samples = 1, .edge_samples = 4, .lobe_samples = 32}, index));
    for (std::size_t p = 0; p < view.mask.size(); ++p)
      if (view.mask.data()[p]) {
        const float* rgb = view.radiance.data() + 3 * p;
        brightest.push_back(std::max({rgb[0], rgb[1], rgb[2]}));
      }
  }
  if (brightest.empty()) throw ConfigError("simulation: the camera never sees the object");
  return quantile(brightest, kMeterQuantile) / kMeterLevel;
}

/// With the lamp of a frame.
RenderOptions SimulatedRig::lit(RenderOptions options, std::size_t index) const {
  if (lights_.empty()) return options;
  options.lamp = {lights_[index].position.cast<float>(), Eigen::Array3f::Constant(kLampPower)};
  options.lighting = kDimmed;
  return options;
}

/// The mean of what is seen while the camera turns; the mask is that of the middle.
RenderedView SimulatedRig::blurred(const CameraStation& station, std::size_t index) const {
  const RenderOptions coarse = lit({.object_samples = 1, .edge_samples = 4, .lobe_samples = 8}, index);
  RenderedView mean{ImageF(camera().width, camera().height, 3), {}};
  for (int i = 0; i < kBlurSteps; ++i) {
    RenderedView moment = tracer_.render(lens_, station.at((i + 0.5) / kBlurSteps - 0.5), coarse);
    for (std::size_t k = 0; k < mean.radiance.size(); ++k)
      mean.radiance.data()[k] += moment.radiance.data()[k] / kBlurSteps;
    if (i == kBlurSteps / 2) mean.mask = std::move(moment.mask);
  }
  return mean;
}

double SimulatedRig::blur_px(std::size_t index) const {
  return path_.at(index).streak_px(camera(), bounding_sphere(object().mesh).centre);
}

SimulatedFrame SimulatedRig::frame(std::size_t index) const {
  const CameraStation& station = path_.at(index);
  SimulatedFrame frame;
  frame.camera_from_object = station.camera_from_object;
  frame.blur_px = blur_px(index);
  if (!lights_.empty()) frame.light = lights_[index];
  RenderedView view = station.moves() ? blurred(station, index) : tracer_.render(lens_, station.at(0), lit({}, index));
  frame.mask = std::move(view.mask);
  frame.radiance = std::move(view.radiance);
  for (std::size_t k = 0; k < frame.radiance.size(); ++k)
    frame.radiance.data()[k] = static_cast<float>(frame.radiance.data()[k] / white_level_);
  frame.radiance = through_lens(frame.radiance, kLensSpotPx);
  ImageF mosaic = mosaic_rggb(frame.radiance);
  add_sensor_noise(mosaic, {}, mix_bits(options_.seed) + index);
  frame.raw = quantize_rggb(mosaic);
  return frame;
}

}  // namespace sheen
