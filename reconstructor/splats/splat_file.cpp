// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splat_file.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/files.h"

namespace sheen {
namespace {

std::vector<std::string> property_names(int degree) {
  std::vector<std::string> names{"x", "y", "z", "nx", "ny", "nz"};
  const auto add = [&](const std::string& name, int count) {
    for (int i = 0; i < count; ++i) names.push_back(name + std::to_string(i));
  };
  add("f_dc_", 3);
  add("f_rest_", 3 * ((degree + 1) * (degree + 1) - 1));
  names.push_back("opacity");
  add("scale_", 3);
  add("rot_", 4);
  return names;
}

}  // namespace

std::size_t splat_bytes(int degree) {
  return sizeof(float) * property_names(degree).size();
}

void write_splats(const std::filesystem::path& path, const Splats& splats, const Eigen::Vector3d& origin) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(splats.shapes.size()) + "\n";
  for (const std::string& name : property_names(splats.degree)) out += "property float " + name + "\n";
  out += "end_header\n";
  const auto put = [&](double value) {
    const float written = static_cast<float>(value);
    out.append(reinterpret_cast<const char*>(&written), sizeof(written));
  };
  for (std::size_t i = 0; i < splats.shapes.size(); ++i) {
    const SplatShape& shape = splats.shapes[i];
    const Eigen::Vector3f normal = shape.turn * Eigen::Vector3f::UnitX();
    for (int k = 0; k < 3; ++k) put(shape.centre[k] + origin[k]);
    for (int k = 0; k < 3; ++k) put(normal[k]);
    for (int c = 0; c < 3; ++c) put(splats.channel(i, c)[0]);
    for (int c = 0; c < 3; ++c)
      for (int term = 1; term < splats.terms(); ++term) put(splats.channel(i, c)[term]);
    put(std::log(shape.opacity / (1 - shape.opacity)));
    for (int k = 0; k < 3; ++k) put(std::log(shape.deviation[k]));
    for (const float part : {shape.turn.w(), shape.turn.x(), shape.turn.y(), shape.turn.z()}) put(part);
  }
  write_file(path, out);
}

}  // namespace sheen
