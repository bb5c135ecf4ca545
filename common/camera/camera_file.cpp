// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/base/json_fields.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr char kFormat[] = "sheen-camera";
constexpr int kVersion = 1;
constexpr double kAnyNumber = 1e9;  ///< `validation_error` knows the true limits

template <typename T, std::size_t n>
std::array<T, n> read_array(const JsonFields& fields, const json& object, const std::string& key,
                            const std::string& where) {
  const json& values = fields.array(fields.member(object, key, where), where + key, n, n);
  std::array<T, n> result;
  for (std::size_t i = 0; i < n; ++i)
    result[i] = static_cast<T>(fields.number(values[i], where + key, -kAnyNumber, kAnyNumber));
  return result;
}

PhotometricCalibration read_photometric(const JsonFields& fields, const json& part) {
  const std::string where = "photometric.";
  const auto number = [&](const json& object, const char* key, const std::string& of) {
    return fields.number(fields.member(object, key, of), of + key, -kAnyNumber, kAnyNumber);
  };
  PhotometricCalibration result;
  Photometry& photometry = result.photometry;
  result.response = fields.text(fields.member(part, "response", where), where + "response");
  result.gamma = number(part, "gamma", where);
  result.black_level = number(part, "black_level", where);
  result.black_level_uncertainty = number(part, "black_level_uncertainty", where);
  result.reference_value = number(part, "reference_value", where);
  photometry.saturation = static_cast<float>(number(part, "saturation", where));
  photometry.response = read_array<float, 256>(fields, part, "light", where);
  result.response_uncertainty = read_array<float, 256>(fields, part, "light_uncertainty", where);
  if (const auto found = part.find("vignette"); found != part.end()) {
    const std::string of = where + "vignette.";
    const auto centre = read_array<double, 2>(fields, *found, "centre", of);
    photometry.vignette = {centre[0], centre[1], read_array<double, 3>(fields, *found, "k", of)};
    result.vignette = {number(*found, "uncertainty", of), number(*found, "centre_uncertainty_px", of)};
  }
  if (const auto found = part.find("white_balance"); found != part.end()) {
    const std::string of = where + "white_balance.";
    photometry.white_balance = read_array<float, 3>(fields, *found, "gains", of);
    result.white_balance = read_array<double, 3>(fields, *found, "uncertainty", of);
  }
  return result;
}

json photometric_json(const PhotometricCalibration& p) {
  json part = {{"response", p.response},
               {"gamma", p.gamma},
               {"black_level", p.black_level},
               {"black_level_uncertainty", p.black_level_uncertainty},
               {"saturation", p.photometry.saturation},
               {"reference_value", p.reference_value},
               {"light", p.photometry.response},
               {"light_uncertainty", p.response_uncertainty}};
  if (p.vignette)
    part["vignette"] = {{"centre", {p.photometry.vignette.cx, p.photometry.vignette.cy}},
                        {"k", p.photometry.vignette.k},
                        {"uncertainty", p.vignette->worst},
                        {"centre_uncertainty_px", p.vignette->centre_px}};
  if (p.white_balance)
    part["white_balance"] = {{"gains", p.photometry.white_balance}, {"uncertainty", *p.white_balance}};
  return part;
}

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
  if (const auto known = file.find("photometric"); known != file.end()) {
    result.photometric = read_photometric(fields, *known);
    const std::string wrong = validation_error(result.photometric->photometry, {camera.width, camera.height});
    if (!wrong.empty()) throw FileError(path.string(), wrong);
  }
  return result;
}

json camera_json(const Camera& camera) {
  const std::ptrdiff_t numbers = camera.lens == LensModel::kFisheye ? 4 : 5;
  return {{"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"lens", lens_name(camera.lens)},
          {"distortion", std::vector<double>(camera.distortion.begin(), camera.distortion.begin() + numbers)}};
}

void save_camera(const CameraFile& file, const std::filesystem::path& path) {
  json content = camera_json(file.camera);
  content.update({{"format", kFormat}, {"version", kVersion}, {"focal_uncertainty", file.focal_uncertainty}});
  if (file.photometric) content["photometric"] = photometric_json(*file.photometric);
  write_file(path, content.dump(1) + "\n");
}

}  // namespace sheen
