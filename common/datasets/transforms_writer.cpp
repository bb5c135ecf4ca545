// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/datasets/dataset.h"

namespace sheen {

namespace {

using Json = nlohmann::ordered_json;

Json matrix_rows(const Eigen::Matrix4d& m, int rows) {
  Json out = Json::array();
  for (int r = 0; r < rows; ++r) out.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return out;
}

/// One name for all views where there is one, as some readers know only one.
const char* camera_model(std::span<const DatasetView> views) {
  const auto fisheye = [](const DatasetView& v) { return v.camera.lens == LensModel::kFisheye; };
  const auto distorted = [](const DatasetView& v) { return v.camera.has_distortion(); };
  if (std::all_of(views.begin(), views.end(), fisheye)) return "OPENCV_FISHEYE";
  if (std::any_of(views.begin(), views.end(), fisheye)) return nullptr;
  return std::any_of(views.begin(), views.end(), distorted) ? "OPENCV" : "PINHOLE";
}

Json camera_fields(const Camera& camera) {
  Json out;
  out["w"] = camera.width;
  out["h"] = camera.height;
  out["fl_x"] = camera.fx;
  out["fl_y"] = camera.fy;
  out["cx"] = camera.cx + 0.5;
  out["cy"] = camera.cy + 0.5;
  if (!camera.has_distortion()) return out;
  const bool fisheye = camera.lens == LensModel::kFisheye;
  const std::array<const char*, 5> names =
      fisheye ? std::array{"k1", "k2", "k3", "k4", ""} : std::array{"k1", "k2", "p1", "p2", "k3"};
  for (std::size_t i = 0; i < (fisheye ? 4u : 5u); ++i) out[names[i]] = camera.distortion[i];
  return out;
}

/// A line for each of its fields, and for each frame.
std::string in_lines(const Json& object) {
  std::string text = "{";
  for (const auto& [key, value] : object.items()) {
    text += (text == "{" ? "\n\"" : ",\n\"") + key + "\": ";
    if (key != "frames") {
      text += value.dump();
      continue;
    }
    for (std::size_t i = 0; i < value.size(); ++i) text += (i == 0 ? "[\n" : ",\n") + value[i].dump();
    text += "\n]";
  }
  return text + "\n}\n";
}

/// Null for a light that needs no key.
const char* light_key(const LightState& light) {
  if (light.kind == LightKind::kPoint) return "light_position";
  return light.kind == LightKind::kDirectional ? "light_direction" : nullptr;
}

}  // namespace

std::string transforms_text(const std::filesystem::path& file, const std::vector<DatasetView>& views,
                            const std::string& points) {
  if (views.empty()) throw FileError(file.string(), "cannot be written: there are no views");
  const auto training_view = [](const DatasetView& v) { return v.purpose == Purpose::kTraining; };
  const Json shared_camera = camera_fields(views[0].camera);
  const bool one_camera = camera_model(views) && std::all_of(views.begin(), views.end(), [&](const DatasetView& v) {
                            return camera_fields(v.camera) == shared_camera;
                          });
  const char* model = camera_model(views);
  Json out;
  if (model) out["camera_model"] = model;
  if (one_camera) out.update(shared_camera);
  // The tools that read this must neither turn nor scale the poses, or they no longer fit the mesh.
  out["applied_transform"] = matrix_rows(Eigen::Matrix4d::Identity(), 3);
  out["orientation_override"] = "none";
  if (std::all_of(views.begin(), views.end(), [](const DatasetView& v) { return v.exposure_locked; }))
    out["exposure_locked"] = true;
  if (!points.empty()) out["ply_file_path"] = points;
  Json training = Json::array(), held_out = Json::array();
  for (const DatasetView& view : views) {
    Json frame;
    frame["file_path"] = view.name;
    if (view.mask_path) frame["mask_path"] = relative_name(*view.mask_path, file.parent_path());
    if (!model) frame["camera_model"] = camera_model({&view, 1});
    if (!one_camera) frame.update(camera_fields(view.camera));
    const Eigen::Matrix4d object_from_gl =
        view.camera_from_object.inverse().matrix() * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
    frame["transform_matrix"] = matrix_rows(object_from_gl, 4);
    if (const char* key = light_key(view.light)) {
      const Eigen::Vector3d& p = view.light.position;
      frame[key] = {p.x(), p.y(), p.z()};
      if (const Eigen::Vector3f& rgb = view.light.rgb; rgb != Eigen::Vector3f::Ones())
        frame["light_rgb"] = {rgb.x(), rgb.y(), rgb.z()};
    }
    out["frames"].push_back(std::move(frame));
    (view.purpose == Purpose::kHeldOut ? held_out : training).push_back(view.name);
  }
  if (!held_out.empty() || std::all_of(views.begin(), views.end(), training_view)) out["train_filenames"] = training;
  if (!held_out.empty()) {
    out["val_filenames"] = held_out;
    out["test_filenames"] = held_out;
  }
  try {
    return in_lines(out);
  } catch (const nlohmann::json::exception& error) {
    throw FileError(file.string(), std::string("cannot be written: ") + error.what());
  }
}

void write_transforms(const std::filesystem::path& file, const std::vector<DatasetView>& views,
                      const std::string& points) {
  write_file(file, transforms_text(file, views, points));
}

}  // namespace sheen
