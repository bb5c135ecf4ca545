// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/files/json_parts.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kCameraNumbers = 19;
constexpr double kMost = 1e9;

/// A list of numbers, so many where `size` is given.
std::vector<double> numbers(const Json& json, const std::string& what, std::size_t size) {
  if (!json.is_array()) throw std::invalid_argument(what + "must be a list");
  if (json.size() != size)
    throw std::invalid_argument(what + "has " + std::to_string(json.size()) + " entries instead of " +
                                std::to_string(size));
  std::vector<double> list;
  for (const Json& entry : json) {
    if (!entry.is_number() || !(std::abs(entry.get<double>()) <= kMost))
      throw std::invalid_argument(what + "entry " + std::to_string(list.size()) + " is not a valid number here");
    list.push_back(entry.get<double>());
  }
  return list;
}

Eigen::VectorXf vector(const std::vector<double>& list) {
  return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size())).cast<float>();
}

template <typename Matrix>
std::vector<float> list_of(const Matrix& m) {
  return std::vector<float>(m.data(), m.data() + m.size());
}

}  // namespace

OrderedJson cameras_to_json(const std::vector<PosedCamera>& cameras) {
  OrderedJson list = OrderedJson::array();
  for (const auto& [camera, pose] : cameras) {
    const auto& d = camera.distortion;
    const auto& q = pose.rotation;
    const auto& t = pose.translation;
    list.push_back({camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                    static_cast<int>(camera.lens), d[0], d[1], d[2], d[3], d[4], q.w(), q.x(), q.y(), q.z(), t.x(),
                    t.y(), t.z()});
  }
  return list;
}

std::vector<PosedCamera> cameras_from_json(const Json& json) {
  if (!json.is_array()) throw std::invalid_argument("must be a list");
  std::vector<PosedCamera> cameras;
  for (const Json& entry : json) {
    const std::string which = "entry " + std::to_string(cameras.size()) + " ";
    const std::vector<double> n = numbers(entry, which, kCameraNumbers);
    if (n[6] != 0 && n[6] != 1) throw std::invalid_argument(which + "has a lens that is not known");
    PosedCamera posed;
    posed.camera = {.width = static_cast<int>(n[0]),
                    .height = static_cast<int>(n[1]),
                    .fx = n[2],
                    .fy = n[3],
                    .cx = n[4],
                    .cy = n[5],
                    .lens = static_cast<LensModel>(static_cast<int>(n[6])),
                    .distortion = {n[7], n[8], n[9], n[10], n[11]}};
    if (const std::string error = validation_error(posed.camera); !error.empty())
      throw std::invalid_argument(which + "is not a camera: " + error);
    posed.camera_from_object.rotation = Eigen::Quaterniond(n[12], n[13], n[14], n[15]);
    if (!(std::abs(posed.camera_from_object.rotation.norm() - 1) < 1e-6))
      throw std::invalid_argument(which + "has a rotation that is not valid");
    posed.camera_from_object.translation = {n[16], n[17], n[18]};
    cameras.push_back(posed);
  }
  return cameras;
}

OrderedJson kernel_to_json(const ViewKernel& kernel) {
  return {kernel.scale_rad, kernel.nugget, static_cast<int>(kernel.shape)};
}

ViewKernel kernel_from_json(const Json& json) {
  const std::vector<double> kernel = numbers(json, "kernel: ", 3);
  if (!(kernel[0] >= 1e-6) || !(kernel[1] >= 0) || (kernel[2] != 0 && kernel[2] != 1))
    throw std::invalid_argument("kernel: must be a positive scale, a nugget and a shape");
  return {static_cast<float>(kernel[0]), static_cast<float>(kernel[1]), static_cast<KernelShape>(kernel[2])};
}

OrderedJson exposure_to_json(const ExposureField& exposure) {
  return {{"centre", list_of(exposure.centre)},
          {"directions", list_of(exposure.directions)},
          {"mean", list_of(exposure.log_gain.mean)},
          {"weights", list_of(exposure.log_gain.weights)},
          {"kernel", kernel_to_json(exposure.kernel)}};
}

ExposureField exposure_from_json(const Json& json) {
  if (!json.is_object()) throw std::invalid_argument("must be an object");
  const auto field = [&](const char* name) -> const Json& {
    const auto found = json.find(name);
    if (found == json.end()) throw std::invalid_argument(std::string(name) + ": is missing");
    return *found;
  };
  const Json& directions = field("directions");
  if (!directions.is_array() || directions.size() % 3 != 0)
    throw std::invalid_argument("directions: must be a list of three numbers per view");
  const std::size_t views = directions.size() / 3;
  ExposureField exposure;
  exposure.centre = vector(numbers(field("centre"), "centre: ", 3));
  if (views == 0) return exposure;
  exposure.directions =
      vector(numbers(directions, "directions: ", 3 * views)).reshaped(3, static_cast<Eigen::Index>(views));
  exposure.log_gain.mean = vector(numbers(field("mean"), "mean: ", 1));
  exposure.log_gain.weights = vector(numbers(field("weights"), "weights: ", views)).transpose();
  exposure.kernel = kernel_from_json(field("kernel"));
  return exposure;
}

OrderedJson reflection_to_json(const ReflectionDrift* reflection) {
  return reflection ? OrderedJson(list_of(reflection->coefficients)) : OrderedJson::array();
}

std::shared_ptr<const ReflectionDrift> reflection_from_json(const Json& json) {
  if (!json.is_array()) throw std::invalid_argument("must be a list");
  if (json.empty()) return nullptr;
  auto reflection = std::make_shared<ReflectionDrift>();
  reflection->coefficients = vector(numbers(json, "", kHarmonics));
  return reflection;
}

}  // namespace sheen
