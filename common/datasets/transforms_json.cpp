// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/transforms_json.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "common/base/errors.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/pose_check.h"

namespace sheen {

namespace {

using Json = nlohmann::json;

/// Typed look-ups that name file, frame and field when something is wrong.
class Fields {
 public:
  Fields(const std::string& file, std::string where, const Json& own, const Json* shared = nullptr)
      : file_(file), where_(std::move(where)), own_(own), shared_(shared) {}

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw FileError(file_, where_ + (where_.empty() || field.empty() ? "" : ", ") + field + ": " + what);
  }
  /// The frame's own value, else that for all frames. Null counts as absent.
  const Json* find(const char* field) const {
    for (const Json* object : {&own_, shared_})
      if (object)
        if (const auto found = object->find(field); found != object->end() && !found->is_null()) return &*found;
    return nullptr;
  }
  std::optional<double> number(const char* field) const {
    const Json* value = find(field);
    if (!value) return std::nullopt;
    if (!value->is_number()) fail(field, "must be a number");
    return value->get<double>();
  }
  std::optional<std::string> text(const char* field) const {
    const Json* value = find(field);
    if (!value) return std::nullopt;
    if (!value->is_string()) fail(field, "must be a text");
    return value->get<std::string>();
  }
  std::optional<bool> boolean(const char* field) const {
    const Json* value = find(field);
    if (!value) return std::nullopt;
    if (!value->is_boolean()) fail(field, "must be true or false");
    return value->get<bool>();
  }
  /// Three numbers, of at most `kLongestLength`.
  std::optional<Eigen::Vector3d> vector(const char* field) const {
    const Json* value = find(field);
    if (!value) return std::nullopt;
    if (!value->is_array() || value->size() != 3) fail(field, "must be 3 numbers");
    Eigen::Vector3d v;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(*value)[i].is_number()) fail(field, "must be 3 numbers");
      v[Eigen::Index(i)] = (*value)[i].get<double>();
    }
    if (const std::string wrong = place_error(v); !wrong.empty()) fail(field, wrong);
    return v;
  }
  /// A matrix of `rows` (or, where `or_less`, one less) rows and 4 columns; what is missing is the identity's.
  std::optional<Eigen::Matrix4d> matrix(const char* field) const {
    const Json* value = find(field);
    if (!value) return std::nullopt;
    if (!value->is_array() || (value->size() != 3 && value->size() != 4)) fail(field, "must have 3 or 4 rows");
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    for (std::size_t r = 0; r < value->size(); ++r) {
      const Json& row = (*value)[r];
      if (!row.is_array() || row.size() != 4) fail(field, "row " + std::to_string(r) + " must have 4 numbers");
      for (std::size_t c = 0; c < 4; ++c) {
        if (!row[c].is_number()) fail(field, "row " + std::to_string(r) + " must have 4 numbers");
        m(Eigen::Index(r), Eigen::Index(c)) = row[c].get<double>();
      }
    }
    if (!m.allFinite()) fail(field, "is not finite");
    if ((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6)
      fail(field, "its last row must be 0 0 0 1");
    return m;
  }
  /// The same with a checked rotation part.
  std::optional<Eigen::Matrix4d> rigid(const char* field) const {
    auto m = matrix(field);
    if (!m) return m;
    Eigen::Matrix3d rotation = m->topLeftCorner<3, 3>();
    if (const std::string wrong = make_rotation(rotation); !wrong.empty()) fail(field, wrong);
    if (const std::string wrong = place_error(m->topRightCorner<3, 1>()); !wrong.empty()) fail(field, wrong);
    m->topLeftCorner<3, 3>() = rotation;
    return m;
  }

 private:
  const std::string& file_;
  std::string where_;
  const Json& own_;
  const Json* shared_;
};

/// A text from the file as an error may show it: short and without control characters.
std::string shown(std::string text) {
  constexpr std::size_t kLength = 200;
  if (text.size() > kLength) text.resize(kLength);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
  return text;
}

struct LensKind {
  LensModel lens;
  std::vector<const char*> coefficients;  ///< fields it has, in the order of Camera::distortion; null: stays 0
};

const LensKind kBrown{LensModel::kOpenCv, {"k1", "k2", "p1", "p2", "k3"}};
const LensKind kEquidistant{LensModel::kFisheye, {"k1", "k2", "k3", "k4"}};
const std::map<std::string_view, LensKind> kLenses = {
    {"OPENCV", kBrown},
    {"PINHOLE", {LensModel::kOpenCv, {}}},
    {"SIMPLE_PINHOLE", {LensModel::kOpenCv, {}}},
    {"SIMPLE_RADIAL", {LensModel::kOpenCv, {"k1"}}},
    {"RADIAL", {LensModel::kOpenCv, {"k1", "k2"}}},
    {"OPENCV_FISHEYE", kEquidistant},
    {"SIMPLE_RADIAL_FISHEYE", {LensModel::kFisheye, {"k1"}}},
    {"RADIAL_FISHEYE", {LensModel::kFisheye, {"k1", "k2"}}},
};

/// Of cameras that instant-ngp and others know and this program does not: such images are of other pixels.
void refuse_other_cameras(const Fields& fields) {
  for (const char* field : {"ftheta_p0", "ftheta_p1", "latlong", "equirectangular", "orthographic", "sk_x", "sk_y"})
    if (const Json* value = fields.find(field); value && *value != 0 && *value != false)
      fields.fail(field, "such a camera is not supported; undistort the images to PINHOLE");
  if (const Json* shutter = fields.find("rolling_shutter"))
    for (const Json& value : shutter->is_array() ? *shutter : Json::array({*shutter}))
      if (value.is_number() && value != 0)
        fields.fail("rolling_shutter",
                    "an image whose rows were taken one after the other has no one pose; set it to 0 where the camera "
                    "hardly moved");
}

LensKind lens_kind(const Fields& fields) {
  if (const auto name = fields.text("camera_model")) {
    if (const auto found = kLenses.find(*name); found != kLenses.end()) return found->second;
    fields.fail("camera_model", "\"" + shown(*name) + "\" is not supported; undistort the images to PINHOLE");
  }
  const Json* fisheye = fields.find("is_fisheye");
  return fisheye && fisheye->is_boolean() && fisheye->get<bool>() ? kEquidistant : kBrown;
}

int side(const Fields& fields, const char* field, double value) {
  constexpr int kMaxSide = 1 << 16;
  if (!(value >= 1 && value <= kMaxSide && value == std::floor(value)))
    fields.fail(field, "must be a whole number of pixels, 1.." + std::to_string(kMaxSide));
  return static_cast<int>(value);
}

/// From a field of view, where no focal length is given.
std::optional<double> focal_from_angle(const Fields& fields, const char* field, int pixels) {
  const auto angle = fields.number(field);
  if (!angle) return std::nullopt;
  if (!(*angle > 0 && *angle < M_PI)) fields.fail(field, "must be between 0 and pi");
  return pixels / 2.0 / std::tan(*angle / 2);
}

/// What is wrong with a camera, by the names that its numbers have in this format.
std::string in_its_words(std::string wrong) {
  for (const auto& [ours, theirs] : std::map<std::string, std::string>{
           {"camera.fx", "fl_x"}, {"camera.fy", "fl_y"}, {"camera.cx", "cx"}, {"camera.cy", "cy"}})
    if (const std::size_t at = wrong.find(ours); at != std::string::npos) wrong.replace(at, ours.size(), theirs);
  return wrong;
}

/// A frame cannot be used, but the others can.
class NoImage : public Error {
 public:
  NoImage(std::string field, const std::string& what) : Error(what), field(std::move(field)) {}
  const std::string field;
};

ImageSize size_of(const std::filesystem::path& image, const ImageFiles& images) {
  try {
    return images.size(image);
  } catch (const FileError& error) {
    if (!images.left_out) throw;
    throw NoImage("file_path", error.what());
  }
}

Camera parse_camera(const Fields& fields, const std::filesystem::path& image, const ImageFiles& images) {
  Camera camera;
  const auto w = fields.number("w"), h = fields.number("h");
  if (w.has_value() != h.has_value()) fields.fail(w ? "h" : "w", "is missing");
  if (w) {
    camera.width = side(fields, "w", *w);
    camera.height = side(fields, "h", *h);
  } else {
    const ImageSize size = size_of(image, images);
    camera.width = side(fields, "w", size.width);
    camera.height = side(fields, "h", size.height);
  }

  auto fx = fields.number("fl_x"), fy = fields.number("fl_y");
  if (!fx && !fy) {
    fx = focal_from_angle(fields, "camera_angle_x", camera.width);
    fy = focal_from_angle(fields, "camera_angle_y", camera.height);
  }
  if (!fx && !fy) fields.fail("fl_x", "is missing, and so is camera_angle_x");
  camera.fx = fx.value_or(fy.value_or(0));
  camera.fy = fy.value_or(camera.fx);
  // There the first pixel's centre is (0.5, 0.5), here (0, 0).
  camera.cx = fields.number("cx").value_or(camera.width / 2.0) - 0.5;
  camera.cy = fields.number("cy").value_or(camera.height / 2.0) - 0.5;

  refuse_other_cameras(fields);
  const LensKind kind = lens_kind(fields);
  camera.lens = kind.lens;
  std::set<std::string_view> used;
  for (std::size_t i = 0; i < kind.coefficients.size(); ++i) {
    camera.distortion[i] = fields.number(kind.coefficients[i]).value_or(0);
    used.insert(kind.coefficients[i]);
  }
  for (const char* coefficient : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"})
    if (!used.contains(coefficient) && fields.number(coefficient).value_or(0) != 0)
      fields.fail(coefficient, "is not 0, but the camera_model has no such coefficient");
  if (const std::string wrong = validation_error(camera); !wrong.empty()) fields.fail("", in_its_words(wrong));
  return camera;
}

Rigid3 parse_pose(const Fields& fields) {
  const auto object_from_gl = fields.rigid("transform_matrix");
  if (!object_from_gl) fields.fail("transform_matrix", "is missing");
  const Eigen::Matrix4d object_from_camera = *object_from_gl * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  return Rigid3::from_matrix(object_from_camera).inverse();
}

LightState parse_light(const Fields& fields) {
  LightState light;
  const auto position = fields.vector("light_position"), direction = fields.vector("light_direction");
  if (position && direction) fields.fail("light_direction", "stands beside light_position; give one of them");
  if (direction) {
    if (!(direction->norm() > 0)) fields.fail("light_direction", "must not be zero");
    light = {.kind = LightKind::kDirectional, .position = direction->normalized()};
  }
  if (position) light = {.kind = LightKind::kPoint, .position = *position};
  if (const auto rgb = fields.vector("light_rgb")) {
    if (!(rgb->minCoeff() > 0)) fields.fail("light_rgb", "must be three numbers above 0");
    light.rgb = rgb->cast<float>();
  }
  return light;
}

/// The lists that say which views are held out; they may name those left out.
void apply_lists(const Fields& top, std::vector<DatasetView>& views, const std::set<std::string>& left_out,
                 UnknownNames unknown_names) {
  std::map<std::string, DatasetView*> by_name;
  for (DatasetView& view : views) by_name[normal_name(view.name)] = &view;
  std::set<const DatasetView*> training, held_out;
  bool any_list = false;
  for (const char* field : {"train_filenames", "val_filenames", "test_filenames"}) {
    const Json* list = top.find(field);
    if (!list) continue;
    any_list = true;
    if (!list->is_array()) top.fail(field, "must be a list of file names");
    for (const Json& entry : *list) {
      if (!entry.is_string()) top.fail(field, "must be a list of file names");
      const std::string name = normal_name(entry.get<std::string>());
      const auto found = by_name.find(name);
      if (found == by_name.end()) {
        if (unknown_names == UnknownNames::kIgnored || left_out.contains(name)) continue;
        top.fail(field, "no frame has the file_path \"" + shown(entry.get<std::string>()) + "\"");
      }
      if (std::string_view(field) == "train_filenames") training.insert(found->second);
      if (std::string_view(field) == "test_filenames") held_out.insert(found->second);
    }
  }
  if (!any_list) return;
  for (DatasetView& view : views) {
    view.purpose = held_out.contains(&view) ? Purpose::kHeldOut : Purpose::kTraining;
    if (held_out.contains(&view) && training.contains(&view))
      top.fail("test_filenames", "\"" + shown(view.name) + "\" stands in train_filenames as well");
  }
}

DatasetView parse_frame(const Fields& fields, const ImageFiles& images) {
  DatasetView view;
  const auto name = fields.text("file_path");
  if (!name || name->empty()) fields.fail("file_path", "is missing");
  if (name->find('\0') != std::string::npos) fields.fail("file_path", "is not a file name");
  view.name = *name;
  std::replace(view.name.begin(), view.name.end(), '\\', '/');
  view.image_path = images.find(*name);
  if (view.image_path.empty()) throw NoImage("file_path", "there is no such image");
  if (const auto mask = fields.text("mask_path")) {
    if (mask->find('\0') == std::string::npos) view.mask_path = images.find(*mask);
    if (!view.mask_path || view.mask_path->empty())
      throw NoImage("mask_path", "there is no such mask: \"" + shown(*mask) + "\"");
  }
  view.camera_from_object = parse_pose(fields);
  view.light = parse_light(fields);
  view.exposure_locked = fields.boolean("exposure_locked").value_or(false);
  view.camera = parse_camera(fields, view.image_path, images);
  return view;
}

Json parse_json(const std::string& file, const std::string& text) {
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    throw FileError(file, std::string("is not valid JSON: ") + error.what());
  }
}

}  // namespace

std::vector<DatasetView> parse_transforms(const std::string& file, const std::string& text, const ImageFiles& images,
                                          UnknownNames unknown_names) {
  const Json json = parse_json(file, text);
  if (!json.is_object()) throw FileError(file, "must be a JSON object with a list \"frames\"");
  const Fields top(file, "", json);
  const Json* frames = top.find("frames");
  if (!frames || !frames->is_array() || frames->empty()) top.fail("frames", "must be a list of at least one frame");

  std::vector<DatasetView> views;
  std::map<std::string, std::size_t> first_of_name;
  std::set<std::string> left_out;
  for (std::size_t i = 0; i < frames->size(); ++i) {
    const Json& frame = (*frames)[i];
    const auto label = frame.is_object() ? frame.find("file_path") : frame.end();
    const std::string name =
        label != frame.end() && label->is_string() ? " (" + shown(label->get<std::string>()) + ")" : "";
    const std::string where = "frame " + std::to_string(i) + name;
    if (!frame.is_object()) throw FileError(file, where + ": must be a JSON object");
    const Fields fields(file, where, frame, &json);
    const std::string file_path = fields.text("file_path").value_or("");
    const auto [first, is_new] = first_of_name.emplace(normal_name(file_path), i);
    if (!is_new) fields.fail("file_path", "is that of frame " + std::to_string(first->second) + " again");
    try {
      views.push_back(parse_frame(fields, images));
    } catch (const NoImage& error) {
      if (!images.left_out) fields.fail(error.field, error.what());
      images.left_out(file_path, error.what());
      left_out.insert(normal_name(file_path));
    }
  }
  apply_lists(top, views, left_out, unknown_names);
  return views;
}

}  // namespace sheen
