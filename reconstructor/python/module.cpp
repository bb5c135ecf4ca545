// SPDX-License-Identifier: Apache-2.0
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/capture/moved_origin.h"
#include "reconstructor/python/exceptions.h"
#include "reconstructor/python/open_model.h"
#include "reconstructor/python/words.h"
#include "reconstructor/python/work.h"

namespace sheen {
namespace {

namespace py = pybind11;
using Vector = std::optional<Eigen::Vector3d>;

/// The picture as an array, rows x columns x channels, that owns it.
template <typename T>
py::array_t<T> array_of(Image<T> image) {
  auto owned = std::make_unique<Image<T>>(std::move(image));
  const std::array<py::ssize_t, 3> shape{owned->height(), owned->width(), owned->channels()};
  const T* const pixels = owned->data();
  const py::capsule owner(owned.release(), [](void* kept) { delete static_cast<Image<T>*>(kept); });
  return py::array_t<T>(shape, pixels, owner);
}

const char* in_words(LightKind light) {
  switch (light) {
    case LightKind::kDirectional:
      return "directional";
    case LightKind::kPoint:
      return "point";
    default:
      return "fixed";
  }
}

std::string described(const OpenModel& model) {
  return format("<sheen.Model: %s of %zu images, %zu triangles>", model.saved().kind->title(), model.images(),
                model.snapshot().mesh().triangles.size());
}

py::array_t<double> vertices_of(const Mesh& mesh) {
  py::array_t<double> out({mesh.vertices.size(), std::size_t{3}});
  auto rows = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    for (py::ssize_t c = 0; c < 3; ++c) rows(i, c) = mesh.origin[c] + double(mesh.vertices[std::size_t(i)][c]);
  return out;
}

py::array_t<std::uint32_t> triangles_of(const Mesh& mesh) {
  py::array_t<std::uint32_t> out({mesh.triangles.size(), std::size_t{3}});
  auto rows = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    for (py::ssize_t c = 0; c < 3; ++c) rows(i, c) = mesh.triangles[std::size_t(i)][std::size_t(c)];
  return out;
}

py::array_t<double> bounds_of(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  py::array_t<double> out({2, 3});
  auto rows = out.mutable_unchecked<2>();
  for (py::ssize_t c = 0; c < 3; ++c) {
    rows(0, c) = mesh.origin[c] + double(box.min()[c]);
    rows(1, c) = mesh.origin[c] + double(box.max()[c]);
  }
  return out;
}

/// A row each, in the frame of the mesh's file.
py::array_t<double> lights_of(const ModelSnapshot& model) {
  const std::vector<LightState> lights = model.lights();
  py::array_t<double> out({lights.size(), std::size_t{3}});
  auto rows = out.mutable_unchecked<2>();
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Eigen::Vector3d at = in_frame_at(-model.mesh().origin, lights[i]).position;
    for (int c = 0; c < 3; ++c) rows(py::ssize_t(i), c) = at[c];
  }
  return out;
}

/// What is told to a method of `Model` that draws: from where, and in which light.
struct Asked {
  AskedView view;
  Vector light;
};

/// Adds one: `draw(model, asked, first...)`, where the arguments `first` stand before the others.
template <typename... First, typename Draw, typename... Names>
void add_drawing(py::class_<OpenModel>& model, const char* name, const char* says, Draw draw, const Names&... names) {
  const py::none none;
  const auto method = [draw](const OpenModel& self, const First&... first, const Vector& eye, const Vector& target,
                             const Vector& up, std::optional<double> field_of_view,
                             const std::optional<Eigen::Matrix3d>& intrinsics,
                             const std::optional<Eigen::Matrix4d>& camera_from_object,
                             const std::optional<PosedCamera>& camera, std::optional<int> width,
                             std::optional<int> height, const Vector& light) {
    return draw(self,
                Asked{{eye, target, up, field_of_view, intrinsics, camera_from_object, camera, width, height}, light},
                first...);
  };
  model.def(name, method, names..., py::kw_only(), py::arg("eye") = none, py::arg("target") = none,
            py::arg("up") = none, py::arg("field_of_view") = none, py::arg("intrinsics") = none,
            py::arg("camera_from_object") = none, py::arg("camera") = none, py::arg("width") = none,
            py::arg("height") = none, py::arg("light") = none, says);
}

template <typename T>
auto picture(Image<T> (*of)(const SmoothView&)) {
  return [of](const OpenModel& model, const Asked& asked) {
    const auto painted = [&] {
      const py::gil_scoped_release others_run;
      return of(model.paint(asked.view, asked.light));
    };
    return array_of(painted());
  };
}

py::dict layers_of(const OpenModel& model, const Asked& asked, const std::vector<std::string>& names) {
  const auto painted = [&] {
    const py::gil_scoped_release others_run;
    return model.layers(names, asked.view, asked.light);
  };
  py::dict layers;
  for (auto& [name, image] : painted()) layers[py::str(name)] = array_of(std::move(image));
  return layers;
}

Eigen::Matrix3d intrinsics_of(const PosedCamera& posed) {
  const Camera& c = posed.camera;
  return Eigen::Matrix3d{{c.fx, 0, c.cx}, {0, c.fy, c.cy}, {0, 0, 1}};
}

void add_camera(py::module_& module) {
  py::class_<PosedCamera> camera(module, "Camera", words::kCamera);
  camera.def_property_readonly(
      "width", [](const PosedCamera& c) { return c.camera.width; }, words::kWidth);
  camera.def_property_readonly(
      "height", [](const PosedCamera& c) { return c.camera.height; }, words::kHeight);
  camera.def_property_readonly("intrinsics", &intrinsics_of, words::kIntrinsics);
  camera.def_property_readonly(
      "camera_from_object", [](const PosedCamera& c) { return c.camera_from_object.matrix(); },
      words::kCameraFromObject);
  camera.def_property_readonly(
      "lens", [](const PosedCamera& c) { return c.camera.lens == LensModel::kFisheye ? "fisheye" : "opencv"; },
      words::kLens);
  camera.def_property_readonly(
      "distortion",
      [](const PosedCamera& c) { return Eigen::Map<const Eigen::VectorXd>(c.camera.distortion.data(), 5).eval(); },
      words::kDistortion);
  camera.def("__repr__",
             [](const PosedCamera& c) { return format("<sheen.Camera: %d x %d>", c.camera.width, c.camera.height); });
}

/// In the frame of the mesh's file.
std::vector<PosedCamera> cameras_of(const OpenModel& model) {
  std::vector<PosedCamera> cameras = model.snapshot().cameras();
  for (PosedCamera& camera : cameras) camera = in_frame_at(-model.snapshot().mesh().origin, camera);
  return cameras;
}

using Path = std::optional<std::filesystem::path>;
using Text = std::optional<std::string>;

std::string text_of(const Path& path) {
  return path ? path->string() : "";
}

/// A report as dicts and lists.
py::object parsed(const std::string& json) {
  return py::module_::import("json").attr("loads")(json);
}

py::object evaluate_model(const OpenModel& model, const std::filesystem::path& dataset, bool baselines,
                          const Path& truth, const Path& object) {
  return parsed(evaluated(
      model,
      {.dataset = dataset.string(), .truth = text_of(truth), .object = text_of(object), .baselines = baselines}));
}

py::object export_model(const OpenModel& model, const std::filesystem::path& path, const Text& form) {
  return parsed(exported(model, path, form.value_or("")));
}

py::object build_model(const std::filesystem::path& dataset, const Path& mesh, const Path& out, const Text& model,
                       const Path& config, const std::variant<std::monostate, bool, std::string>& refine,
                       std::optional<int> hold_out, const Text& budget, const Text& target, const Text& memory,
                       const Text& tolerance, const Text& bytes, const Text& loss, const Text& favour) {
  BuildRequest request{
      .dataset = dataset.string(),
      .mesh = text_of(mesh),
      .out = text_of(out),
      .config = text_of(config),
      .model = model.value_or(""),
      .hold_out = hold_out,
      .favour = {favour.value_or("")},
      .limits = {budget.value_or(""), target.value_or(""), memory.value_or(""), tolerance.value_or("")},
      .size = {bytes.value_or(""), loss.value_or("")}};
  if (hold_out.value_or(0) < 0) throw ConfigError("hold_out: must be 0 (none) or more");
  if (config && model) throw ConfigError("config and model: the scene file names the model; give one of the two");
  if (bytes && loss) throw ConfigError("bytes and loss: give one of the two");
  if (const std::string* const what = std::get_if<std::string>(&refine)) request.refine = *what;
  if (const bool* const asked = std::get_if<bool>(&refine)) {
    request.no_refine = !*asked;
    if (*asked) request.refine = "mesh";
  }
  return parsed(built(request));
}

void add_model(py::module_& module) {
  py::class_<OpenModel> model(module, "Model", words::kModel);
  model.def_property_readonly("path", &OpenModel::path, words::kPath);
  model.def_property_readonly(
      "kind", [](const OpenModel& m) { return m.saved().kind->name(); }, words::kKind);
  model.def_property_readonly("images", &OpenModel::images, words::kImages);
  model.def_property_readonly(
      "metadata", [](const OpenModel& m) { return m.saved().metadata; }, words::kMetadata);
  model.def_property_readonly(
      "light_kind", [](const OpenModel& m) { return in_words(m.snapshot().light_kind()); }, words::kLightKind);
  model.def_property_readonly(
      "lights", [](const OpenModel& m) { return lights_of(m.snapshot()); }, words::kLights);
  model.def_property_readonly(
      "bounds", [](const OpenModel& m) { return bounds_of(m.snapshot().mesh()); }, words::kBounds);
  model.def(
      "mesh",
      [](const OpenModel& m) {
        return py::make_tuple(vertices_of(m.snapshot().mesh()), triangles_of(m.snapshot().mesh()));
      },
      words::kMesh);
  model.def("__repr__", &described);
  model.def("evaluate", &evaluate_model, py::arg("dataset"), py::kw_only(), py::arg("baselines") = false,
            py::arg("truth") = py::none(), py::arg("object") = py::none(), words::kEvaluate);
  model.def("export", &export_model, py::arg("path"), py::arg("form") = py::none(), words::kExport);
  model.def_property_readonly("cameras", &cameras_of, words::kCameras);
  add_drawing(model, "render", words::kRender, picture(&premultiplied));
  add_drawing(model, "render_srgb8", words::kRenderSrgb8, picture(&straight_srgb8));
  add_drawing<std::vector<std::string>>(model, "render_layers", words::kRenderLayers, &layers_of, py::arg("layers"));
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  py::options options;
  options.disable_function_signatures();  // the texts have better ones
  module.doc() = words::kModule;
  add_exceptions(module);
  add_camera(module);
  add_model(module);
  module.def(
      "open", [](const std::filesystem::path& path) { return std::make_unique<OpenModel>(path); }, py::arg("path"),
      py::call_guard<py::gil_scoped_release>(), words::kOpen);
  const py::none none;
  module.def("build", &build_model, py::arg("dataset"), py::kw_only(), py::arg("mesh") = none, py::arg("out") = none,
             py::arg("model") = none, py::arg("config") = none, py::arg("refine") = none, py::arg("hold_out") = none,
             py::arg("budget") = none, py::arg("target") = none, py::arg("memory") = none, py::arg("tolerance") = none,
             py::arg("bytes") = none, py::arg("loss") = none, py::arg("favour") = none, words::kBuild);
  module.attr("__version__") = SHEEN_VERSION;
}

}  // namespace sheen
