// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/colmap.h"

#include <array>
#include <cmath>

#include "common/base/errors.h"
#include "common/datasets/pose_check.h"

namespace sheen {

namespace {

/// Parameters in COLMAP's order as letters: f (both focal lengths), x y (one each), u v (principal point), then the
/// places in Camera::distortion, '0' for one that must be zero. Null: not supported.
struct Model {
  const char* name;
  LensModel lens;
  const char* parameters;
};

constexpr LensModel kBrown = LensModel::kOpenCv, kEquidistant = LensModel::kFisheye;
// Distortion places: a b c d e = k1 k2 p1 p2 k3 (Brown), k1 k2 k3 k4 (equidistant).
constexpr std::array<Model, 11> kModels{{{"SIMPLE_PINHOLE", kBrown, "fuv"},
                                         {"PINHOLE", kBrown, "xyuv"},
                                         {"SIMPLE_RADIAL", kBrown, "fuva"},
                                         {"RADIAL", kBrown, "fuvab"},
                                         {"OPENCV", kBrown, "xyuvabcd"},
                                         {"OPENCV_FISHEYE", kEquidistant, "xyuvabcd"},
                                         {"FULL_OPENCV", kBrown, "xyuvabcde000"},
                                         {"FOV", kBrown, nullptr},
                                         {"SIMPLE_RADIAL_FISHEYE", kEquidistant, "fuva"},
                                         {"RADIAL_FISHEYE", kEquidistant, "fuvab"},
                                         {"THIN_PRISM_FISHEYE", kEquidistant, nullptr}}};

const Model* find_model(int id) {
  if (id < 0 || id >= static_cast<int>(kModels.size()) || !kModels[id].parameters) return nullptr;
  return &kModels[id];
}

}  // namespace

int colmap_model_id(std::string_view name) {
  for (std::size_t i = 0; i < kModels.size(); ++i)
    if (kModels[i].name == name) return static_cast<int>(i);
  return -1;
}

int colmap_parameter_count(int model_id) {
  const Model* model = find_model(model_id);
  return model ? static_cast<int>(std::string_view(model->parameters).size()) : -1;
}

Camera colmap_camera(int model_id, double width, double height, const std::vector<double>& parameters) {
  const Model* model = find_model(model_id);
  if (!model) throw Error("its model is not supported; undistort the images with COLMAP's image_undistorter");
  if (static_cast<int>(parameters.size()) != colmap_parameter_count(model_id))
    throw Error(std::string(model->name) + " needs " + std::to_string(colmap_parameter_count(model_id)) +
                " parameters, not " + std::to_string(parameters.size()));
  constexpr double kMaxSide = 1 << 16;
  if (!(width >= 1 && width <= kMaxSide && height >= 1 && height <= kMaxSide))
    throw Error("width and height must be 1..65536 pixels");
  Camera camera;
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  camera.lens = model->lens;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = parameters[i];
    switch (const char role = model->parameters[i]) {
      case 'f':
        camera.fx = camera.fy = value;
        break;
      case 'x':
        camera.fx = value;
        break;
      case 'y':
        camera.fy = value;
        break;
      case 'u':
        camera.cx = value - 0.5;
        break;
      case 'v':
        camera.cy = value - 0.5;
        break;
      case '0':
        if (value != 0) throw Error("FULL_OPENCV with k4, k5 or k6 is not supported; undistort the images");
        break;
      default:
        camera.distortion[role - 'a'] = value;
    }
  }
  if (const std::string wrong = validation_error(camera); !wrong.empty()) throw Error(wrong);
  return camera;
}

ColmapParameters colmap_parameters(const Camera& camera) {
  const bool fisheye = camera.lens == LensModel::kFisheye;
  const int id = colmap_model_id(fisheye                     ? "OPENCV_FISHEYE"
                                 : !camera.has_distortion()  ? "PINHOLE"
                                 : camera.distortion[4] == 0 ? "OPENCV"
                                                             : "FULL_OPENCV");
  ColmapParameters out{.model = kModels[id].name, .values = {}};
  for (const char role : std::string_view(kModels[id].parameters)) switch (role) {
      case 'x':
        out.values.push_back(camera.fx);
        break;
      case 'y':
        out.values.push_back(camera.fy);
        break;
      case 'u':
        out.values.push_back(camera.cx + 0.5);
        break;
      case 'v':
        out.values.push_back(camera.cy + 0.5);
        break;
      case '0':
        out.values.push_back(0);
        break;
      default:
        out.values.push_back(camera.distortion[role - 'a']);
    }
  return out;
}

Rigid3 colmap_pose(const ColmapImage& image) {
  const double norm = image.rotation_wxyz.norm();
  if (!(std::abs(norm - 1) <= 1e-3))
    throw Error("its rotation is not a unit quaternion (length " + std::to_string(norm) + ")");
  if (const std::string wrong = place_error(image.translation); !wrong.empty()) throw Error("its translation " + wrong);
  const Eigen::Vector4d q = image.rotation_wxyz / norm;
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), image.translation};
}

}  // namespace sheen
