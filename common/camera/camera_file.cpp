// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/base/json_fields.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr char kFormat[] = "sheen-camera";
constexpr int kVersion = 1;
constexpr double kAnyNumber = 1e9;  ///< `validation_error` knows the true limits

}  // namespace

const char* lens_name(LensModel lens) {
  return lens == LensModel::kFisheye ? "fisheye" : "opencv";
}

CameraFile load_camera(const std::filesystem::path& path) {
  const JsonFields fields(path);
  const json file = fields.open(kFormat, kVersion, "make one with `sheen-tracker calibrate`");
  CameraFile result;
  Camera& camera = result.camera;
  const auto number = [&](const char* key) {
    return fields.number(fields.member(file, key, ""), key, -kAnyNumber, kAnyNumber);
  };
  camera.width = static_cast<int>(fields.integer(fields.member(file, "width", ""), "width", 1, 1 << 16));
  camera.height = static_cast<int>(fields.integer(fields.member(file, "height", ""), "height", 1, 1 << 16));
  camera.fx = number("fx");
  camera.fy = number("fy");
  camera.cx = number("cx");
  camera.cy = number("cy");
  const std::string lens = fields.text(fields.member(file, "lens", ""), "lens");
  if (lens != "opencv" && lens != "fisheye") fields.fail("lens", "must be \"opencv\" or \"fisheye\"");
  camera.lens = lens == "fisheye" ? LensModel::kFisheye : LensModel::kOpenCv;
  const json& distortion = fields.array(fields.member(file, "distortion", ""), "distortion", 0, 5);
  for (std::size_t i = 0; i < distortion.size(); ++i)
    camera.distortion[i] = fields.number(distortion[i], "distortion", -kAnyNumber, kAnyNumber);
  if (const std::string wrong = validation_error(camera); !wrong.empty()) throw FileError(path.string(), wrong);
  if (const auto known = file.find("focal_uncertainty"); known != file.end())
    result.focal_uncertainty = fields.number(*known, "focal_uncertainty", 0, 1);
  return result;
}

void save_camera(const CameraFile& file, const std::filesystem::path& path) {
  const Camera& camera = file.camera;
  const std::size_t numbers = camera.lens == LensModel::kFisheye ? 4 : 5;
  const json content = {{"format", kFormat},
                        {"version", kVersion},
                        {"width", camera.width},
                        {"height", camera.height},
                        {"fx", camera.fx},
                        {"fy", camera.fy},
                        {"cx", camera.cx},
                        {"cy", camera.cy},
                        {"lens", lens_name(camera.lens)},
                        {"distortion", std::vector<double>(camera.distortion.begin(),
                                                           camera.distortion.begin() + std::ptrdiff_t(numbers))},
                        {"focal_uncertainty", file.focal_uncertainty}};
  write_file(path, content.dump(1) + "\n");
}

}  // namespace sheen
