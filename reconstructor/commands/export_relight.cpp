// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_number.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/image/color.h"
#include "reconstructor/commands/exports.h"
#include "reconstructor/exchange/polynomial_texture.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

ImageF encoded_picture(const RayPainter& painter, const ModelSnapshot& model, const LightState& light) {
  const PosedCamera& from = model.cameras().front();
  ImageF picture = painter.paint(model, from.camera, from.camera_from_object, light).beauty;
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.data()[i] = srgb_encode(std::min(1.0f, std::max(0.0f, picture.data()[i])));
  return picture;
}

}  // namespace

nlohmann::json export_relight(const ModelSnapshot& model, const std::string& name, const std::filesystem::path& out) {
  const std::vector<LightState> lights = model.lights();
  if (model.light_kind() != LightKind::kDirectional || lights.empty())
    throw ConfigError(name + ": --relight writes models of far lights that move: an irradiance field of a list of " +
                      "directions");
  const bool ptm = out.extension() == ".ptm";
  if (ptm)
    check_writable(out);
  else
    check_writable_folder(out);
  const RayPainter painter(model.mesh());
  const Camera& camera = model.cameras().front().camera;
  PolynomialFit fit(camera.width, camera.height);
  Progress progress("fitting", 2 * lights.size());
  std::size_t done = 0;
  const auto next = [&] {
    if (stop_requested()) throw Error("stopped before it was exported");
    progress.update(++done);
  };
  for (const LightState& light : lights) {
    fit.add(light.position, encoded_picture(painter, model, light));
    next();
  }
  const PolynomialTexture texture = fit.texture();
  double squares = 0;
  for (const LightState& light : lights) {
    const ImageF truth = encoded_picture(painter, model, light), shown = texture.picture(light.position);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double shown_value = std::min(1.0, std::max(0.0, static_cast<double>(shown.data()[i])));
      squares += std::pow(shown_value - static_cast<double>(truth.data()[i]), 2) /
                 static_cast<double>(truth.size() * lights.size());
    }
    next();
  }
  if (ptm)
    write_ptm(out, texture);
  else
    write_relight(out, texture);
  const double psnr_db = -10 * std::log10(squares);
  std::printf("%s written; its polynomials show the model's %zu lights with %.2f dB\n", out.c_str(), lights.size(),
              psnr_db);
  return {{"path", out.string()}, {"lights", lights.size()}, {"psnr_db", json_number(psnr_db)}};
}

}  // namespace sheen
