// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/json_parts.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

Eigen::VectorXf vector(const std::vector<double>& list) {
  return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size())).cast<float>();
}

template <typename Matrix>
std::vector<float> list_of(const Matrix& m) {
  return std::vector<float>(m.data(), m.data() + m.size());
}

}  // namespace

OrderedJson kernel_to_json(const ViewKernel& kernel) {
  return {kernel.scale_rad, kernel.nugget, static_cast<int>(kernel.shape)};
}

ViewKernel kernel_from_json(const Json& json) {
  const std::vector<double> kernel = json_numbers(json, "kernel: ", 3);
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
  exposure.centre = vector(json_numbers(field("centre"), "centre: ", 3));
  if (views == 0) return exposure;
  exposure.directions =
      vector(json_numbers(directions, "directions: ", 3 * views)).reshaped(3, static_cast<Eigen::Index>(views));
  exposure.log_gain.mean = vector(json_numbers(field("mean"), "mean: ", 1));
  exposure.log_gain.weights = vector(json_numbers(field("weights"), "weights: ", views)).transpose();
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
  reflection->coefficients = vector(json_numbers(json, "", kHarmonics));
  return reflection;
}

}  // namespace sheen
