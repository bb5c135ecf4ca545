// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/applied_transform.h"

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/files.h"
#include "common/datasets/pose_check.h"

namespace sheen {

std::optional<Eigen::Matrix4d> applied_to_poses(const std::filesystem::path& dataset) {
  using Json = nlohmann::json;
  std::error_code ignored;
  const auto file = std::filesystem::is_directory(dataset, ignored) ? dataset / "transforms.json" : dataset;
  if (file.extension() != ".json" || !std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  const Json json = Json::parse(read_file(file), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("applied_transform")) return std::nullopt;
  try {
    const auto rows = json.at("applied_transform").get<std::vector<std::array<double, 4>>>();
    const double scale = json.value("applied_scale", 1.0);
    if (rows.size() < 3 || !(scale > 0)) return std::nullopt;
    Eigen::Matrix3d rotation;
    Eigen::Matrix4d applied = Eigen::Matrix4d::Identity();
    for (Eigen::Index r = 0; r < 3; ++r)
      applied.row(r) = Eigen::Map<const Eigen::RowVector4d>(rows[static_cast<std::size_t>(r)].data());
    rotation = applied.topLeftCorner<3, 3>();
    if (!make_rotation(rotation).empty() || !place_error(applied.topRightCorner<3, 1>()).empty()) return std::nullopt;
    applied.topLeftCorner<3, 3>() = rotation;
    applied.topRows<3>() *= scale;
    return applied;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace sheen
