// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/lumigraph_reader.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "reconstructor/coding/camera_json.h"
#include "reconstructor/lumigraph_file/lumigraph_format.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// More than anybody honest asks for.
constexpr std::size_t kMostViews = 100000, kMostLights = 4096;
constexpr int kMostSide = 1 << 15;
constexpr std::size_t kMostCells = std::size_t{1} << 27;

std::size_t cells_in(const Eigen::Vector3i& size) {
  return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
}

/// Throws std::exception.
ShadowHull described_hull(const Json& json) {
  const std::vector<double> origin = json_numbers(json.at("origin"), "hull: origin ", 3),
                            size = json_numbers(json.at("size"), "hull: size ", 3);
  const double cell = json.at("cell");
  for (const double side : size)
    if (!(side >= 0 && side <= ShadowHull::kMostCellsOnASide && side == std::floor(side)))
      throw std::invalid_argument("hull: size cannot be");
  const Eigen::Vector3i cells = Eigen::Map<const Eigen::Vector3d>(size.data()).cast<int>();
  if (cells_in(cells) > kMostCells || !(cell >= 0 && cell < 1e6) || (cells_in(cells) > 0 && !(cell > 0)))
    throw std::invalid_argument("hull: cells cannot be");
  return {Eigen::Map<const Eigen::Vector3d>(origin.data()).cast<float>(), static_cast<float>(cell), cells, {}};
}

/// A view with its camera and lights, its pictures still to be read. Throws std::exception.
std::vector<IntrinsicView> read_description(std::string_view bytes, LumigraphData& data) {
  const Json json = Json::parse(unpacked(bytes));
  const int kind = json.at("light_kind");
  if (kind != static_cast<int>(LightKind::kDirectional) && kind != static_cast<int>(LightKind::kPoint))
    throw std::invalid_argument("light_kind is none that is known");
  data.lights.kind = static_cast<LightKind>(kind);
  const std::vector<double> places = json_numbers(json.at("lights"), "lights ", json.at("lights").size());
  if (places.size() % 3 != 0 || places.size() > 3 * kMostLights)
    throw std::invalid_argument("lights must be x y z each, at most " + std::to_string(kMostLights));
  data.lights.places =
      Eigen::Map<const Eigen::Matrix3Xd>(places.data(), 3, static_cast<Eigen::Index>(places.size() / 3));
  data.error = json.at("error");
  if (!(data.error >= 0 && data.error < 1e6)) throw std::invalid_argument("error cannot be");
  data.of_images = json.at("of_images");
  data.hull = described_hull(json.at("hull"));
  const std::vector<PosedCamera> cameras = cameras_from_json(json.at("cameras"));
  const Json &lights = json.at("view_lights"), &units = json.at("residual_units");
  if (!lights.is_array() || !units.is_array() || lights.size() != cameras.size() || units.size() != cameras.size() ||
      cameras.size() > kMostViews)
    throw std::invalid_argument("must have lights and a unit for each camera");
  std::vector<IntrinsicView> views(cameras.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    views[v].from = cameras[v];
    if (cameras[v].camera.width > kMostSide || cameras[v].camera.height > kMostSide)
      throw std::invalid_argument("has a camera of too many pixels");
    views[v].residual_unit = units[v];
    if (!(views[v].residual_unit >= 0 && views[v].residual_unit < 1e6f))
      throw std::invalid_argument("residual_units: one cannot be");
    if (!lights[v].is_array() || lights[v].empty() || lights[v].size() > places.size() / 3)
      throw std::invalid_argument("view_lights must be lists of lights");
    for (const Json& light : lights[v]) {
      if (!light.is_number_integer()) throw std::invalid_argument("view_lights must be whole numbers");
      const std::int64_t i = light;
      if (i < 0 || i >= data.lights.size() || (!views[v].lights.empty() && i <= views[v].lights.back()))
        throw std::invalid_argument("view_lights: none or not in order: " + std::to_string(i));
      views[v].lights.push_back(static_cast<int>(i));
    }
  }
  return views;
}

template <typename T>
void read_plane(std::string_view& bytes, Image<T>& image, const Camera& camera, int channels) {
  const std::size_t values = std::size_t(camera.width) * camera.height * channels;
  if (bytes.size() < values * sizeof(T)) throw std::invalid_argument("is too short for its camera's pictures");
  image.resize(camera.width, camera.height, channels);
  auto* out = reinterpret_cast<char*>(image.data());
  for (std::size_t b = 0; b < sizeof(T); ++b)
    for (std::size_t i = 0; i < values; ++i) out[i * sizeof(T) + b] = bytes[b * values + i];
  bytes.remove_prefix(values * sizeof(T));
}

bool all_finite(const ImageHalf& image) {
  return std::all_of(image.data(), image.data() + image.size(),
                     [](Eigen::half v) { return std::isfinite(static_cast<float>(v)); });
}

/// `hull` has its place and size as the description says them, and no cells.
ShadowHull read_hull(std::string_view packed_bytes, const ShadowHull& hull) {
  const std::string bytes = unpacked(packed_bytes);
  if (bytes.size() != cells_in(hull.size()))
    throw std::invalid_argument("has not as many cells as its description says");
  std::vector<std::uint8_t> cells(bytes.begin(), bytes.end());
  if (std::any_of(cells.begin(), cells.end(), [](std::uint8_t cell) { return cell > ShadowHull::kSolid; }))
    throw std::invalid_argument("has a cell that is more than solid");
  return {hull.origin(), hull.cell(), hull.size(), std::move(cells)};
}

void require_end(std::string_view rest) {
  if (!rest.empty()) throw std::invalid_argument("is too long for its camera's pictures");
}

void read_planes(std::string_view packed_bytes, IntrinsicView& view) {
  const std::string planes = unpacked(packed_bytes);
  std::string_view rest = planes;
  const Camera& camera = view.from.camera;
  read_plane(rest, view.depth, camera, 1);
  read_plane(rest, view.reflectance, camera, 3);
  read_plane(rest, view.slope, camera, 3);
  read_plane(rest, view.ambient, camera, 1);
  require_end(rest);
  const auto fair = [](float z) { return z >= 0 && z < 1e6f; };
  if (!std::all_of(view.depth.data(), view.depth.data() + view.depth.size(), fair) || !all_finite(view.reflectance) ||
      !all_finite(view.slope) || !all_finite(view.ambient))
    throw std::invalid_argument("holds numbers that cannot be");
}

void read_planes_of_light(std::string_view packed_bytes, IntrinsicView& view) {
  const std::string planes = unpacked(packed_bytes);
  std::string_view rest = planes;
  read_plane(rest, view.arrives.emplace_back(), view.from.camera, 1);
  read_plane(rest, view.residual.emplace_back(), view.from.camera, 3);
  require_end(rest);
}

}  // namespace

LumigraphData read_lumigraph(std::string_view bytes, const std::string& file) {
  Chunks chunks(kLumigraphFileFormat, bytes, file);
  LumigraphData data;
  chunks.required("META");
  std::vector<IntrinsicView> views;
  chunks.read("DESC", [&](std::string_view chunk) { views = read_description(chunk, data); });
  chunks.read("HULL", [&](std::string_view chunk) { data.hull = read_hull(chunk, data.hull); });
  for (IntrinsicView& view : views) {
    chunks.read("VIEW", [&](std::string_view chunk) { read_planes(chunk, view); });
    for (std::size_t i = 0; i < view.lights.size(); ++i)
      chunks.read("LAMP", [&](std::string_view chunk) { read_planes_of_light(chunk, view); });
    data.views.push_back(std::make_shared<const IntrinsicView>(std::move(view)));
  }
  return data;
}

}  // namespace sheen
