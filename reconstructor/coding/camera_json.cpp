// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/camera_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/base/length_limit.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kCameraNumbers = 19;

}  // namespace

std::vector<double> json_numbers(const Json& json, const std::string& what, std::size_t size) {
  if (!json.is_array()) throw std::invalid_argument(what + "must be a list");
  if (json.size() != size)
    throw std::invalid_argument(what + "has " + std::to_string(json.size()) + " entries instead of " +
                                std::to_string(size));
  std::vector<double> list;
  for (const Json& entry : json) {
    if (!entry.is_number() || !(std::abs(entry.get<double>()) <= kLongestLength))
      throw std::invalid_argument(what + "entry " + std::to_string(list.size()) + " is not a valid number here");
    list.push_back(entry.get<double>());
  }
  return list;
}

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
    const std::vector<double> n = json_numbers(entry, which, kCameraNumbers);
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

}  // namespace sheen
