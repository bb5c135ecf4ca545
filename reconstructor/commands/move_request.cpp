// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/move_request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/json_fields.h"
#include "common/base/quantity.h"
#include "common/capture/moved_origin.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::json;

constexpr int kLeastSide = 16;
constexpr int kMostFrames = 100'000;
constexpr double kFarthest = 1e9;      // metres, of an eye
constexpr double kNearestRadii = 1.5;  // of the mesh, of an eye that sees all of it

/// What the views of a path say.
struct Keys {
  std::vector<LookAt> views;
  bool closed = false;
  double fov_deg = 40;  ///< as window and page have it
};

Vector3d point(const JsonFields& fields, const Json& json, const std::string& where) {
  const Json& numbers = fields.array(json, where, 3, 3);
  Vector3d out;
  for (std::size_t i = 0; i < 3; ++i)
    out[static_cast<Eigen::Index>(i)] = fields.number(numbers[i], where, -kFarthest, kFarthest);
  return out;
}

/// Three numbers behind a word of a page's address: "eye=0.1,0.2,0.3".
Vector3d point_in(const JsonFields& fields, const std::string& address, const std::string& word,
                  const std::string& where) {
  Vector3d out;
  const std::size_t at = address.find(word + "=");
  if (at == std::string::npos ||
      std::sscanf(address.c_str() + at + word.size() + 1, "%lf,%lf,%lf", &out.x(), &out.y(), &out.z()) != 3)
    fields.fail(where, "has no " + word + "=x,y,z, as the address of a page does");
  return out;
}

LookAt key_of(const JsonFields& fields, const Json& json, const std::string& where, const Vector3d& up) {
  LookAt view{.eye = {}, .target = {}, .up = up};
  if (json.is_string()) {
    const std::string address = json.get<std::string>();
    view.eye = point_in(fields, address, "eye", where);
    view.target = point_in(fields, address, "target", where);
  } else {
    view.eye = point(fields, fields.member(json, "eye", where + "."), where + ".eye");
    view.target = point(fields, fields.member(json, "target", where + "."), where + ".target");
    if (json.contains("up")) view.up = point(fields, json.at("up"), where + ".up");
  }
  return view;
}

Keys read_keys(const std::string& file, const Vector3d& up) {
  const Json json = Json::parse(read_file(file), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) throw FileError(file, "must be a JSON object with a list \"keys\"");
  const JsonFields fields(file);
  Keys keys;
  const Json& list = fields.array(fields.member(json, "keys", ""), "keys", 2, kMostFrames);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string where = "keys[" + std::to_string(i) + "]";
    keys.views.push_back(key_of(fields, list[i], where, up));
    if (!is_a_view(keys.views.back())) fields.fail(where, "looks nowhere, or along its up direction");
  }
  if (const auto closed = json.find("closed"); closed != json.end()) {
    if (!closed->is_boolean()) fields.fail("closed", "must be true or false");
    keys.closed = closed->get<bool>();
  }
  if (json.contains("fov_deg")) keys.fov_deg = fields.number(json.at("fov_deg"), "fov_deg", 1, 150);
  return keys;
}

}  // namespace

LookAt first_view(const ModelSnapshot& model) {
  const BoundingSphere sphere = bounding_sphere(model.mesh());
  std::vector<double> distances;
  for (const PosedCamera& camera : model.cameras())
    distances.push_back((camera_centre(camera.camera_from_object) - sphere.centre).norm());
  std::sort(distances.begin(), distances.end());
  const double distance = std::max(distances[distances.size() / 2], kNearestRadii * sphere.radius);
  const std::optional<OpeningView> opening = opening_view(model.cameras(), sphere.centre);
  if (!opening) return {sphere.centre + distance * Vector3d::UnitX(), sphere.centre};
  return {sphere.centre + distance * opening->direction, sphere.centre, opening->up};
}

void MoveRequest::add_to(Command& command, const std::vector<Option>& instead_of) {
  Option turns = command.option("--turntable", turntable, "so many pictures once round the object");
  Option swings = command.option("--orbit", orbit,
                                 "so many pictures of a swing before the object, which shows how its highlights move");
  Option path = command.option("--path", keys, "file (JSON) of views; the camera moves smoothly through them");
  turns.check(whole_number_in(2, kMostFrames));
  swings.check(whole_number_in(2, kMostFrames));
  swings.excludes({turns});
  path.excludes({turns, swings});
  for (Option option : {turns, swings, path})
    for (const Option& other : instead_of) option.excludes({other});
  command.option("--size", size, "of the pictures of a moving camera, pixels").show_default();
}

std::vector<DatasetView> views_of(const MoveRequest& request, const ModelSnapshot& model, const std::string& name) {
  if (model.cameras().size() < 2)
    throw ConfigError(name + ": is seen by one camera only, which cannot move; --light-path moves its light");
  const auto [width, height] = parse_image_size("--size", request.size, kLeastSide);
  const ImageSize size{width, height};
  const LookAt first = first_view(model);
  const Vector3d& origin = model.mesh().origin;
  std::vector<PosedCamera> cameras;
  if (request.keys.empty()) {
    cameras = framed(request.turntable > 0 ? turntable(first, request.turntable) : swing(first, request.orbit),
                     model.mesh(), size);
    for (PosedCamera& camera : cameras) camera = in_frame_at(-origin, camera);
  } else {
    const Keys keys = read_keys(request.keys, first.up);
    const std::vector<LookAt> path = through(keys.views, request.frames, keys.closed);
    if (!std::all_of(path.begin(), path.end(), is_a_view))
      throw FileError(request.keys, "its path looks nowhere, or along its up direction, between two keys");
    cameras = with_field(path, keys.fov_deg, size);
  }
  const std::vector<LightState> lights = model.lights();
  const LightState light = lights.empty() ? LightState{} : in_frame_at(-origin, lights.front());
  std::vector<DatasetView> views;
  for (const PosedCamera& camera : cameras)
    views.push_back({.name = format("%05zu", views.size() + 1),
                     .image_path = {},
                     .mask_path = {},
                     .camera = camera.camera,
                     .camera_from_object = camera.camera_from_object,
                     .light = light,
                     .purpose = Purpose::kUnspecified,
                     .exposure_s = {}});
  return views;
}

}  // namespace sheen
