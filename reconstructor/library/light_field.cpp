// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/library/sheen/light_field.h"

#include <Eigen/Core>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/light_field_evaluator.h"
#include "reconstructor/light_field_file/light_field_file.h"

namespace sheen {
namespace {

LightField::Point in_file_frame(const Mesh& mesh, const Eigen::Vector3d& point) {
  const Eigen::Vector3d moved = mesh.origin + point;
  return {moved.x(), moved.y(), moved.z()};
}

CompactModel read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) throw FileError(path, "cannot be read");
  if (!is_light_field_file(bytes)) throw FileError(path, "is no surface light field (.slf)");
  return decode_light_field(bytes, path, one_after_the_other);
}

}  // namespace

struct LightField::Content {
  explicit Content(CompactModel opened) : model(std::move(opened)), light_field(model, one_after_the_other) {
    for (const Eigen::Vector3f& vertex : model.mesh->vertices)
      vertices.push_back(in_file_frame(*model.mesh, vertex.cast<double>()));
    for (const PosedCamera& camera : model.cameras)
      eyes.push_back(in_file_frame(*model.mesh, camera_centre(camera.camera_from_object)));
  }

  CompactModel model;
  LightFieldEvaluator light_field;
  std::vector<Point> vertices, eyes;
};

struct LightField::View::State {
  std::shared_ptr<const Content> content;
  Eigen::MatrixXf coefficients;
  float exposure = 1, brightest = 0;
};

LightField::LightField(const std::string& path) : content_(std::make_shared<const Content>(read(path))) {}
LightField::LightField(LightField&&) noexcept = default;
LightField& LightField::operator=(LightField&&) noexcept = default;
LightField::~LightField() = default;

const std::vector<LightField::Point>& LightField::vertices() const {
  return content_->vertices;
}

const std::vector<LightField::Triangle>& LightField::triangles() const {
  return content_->model.mesh->triangles;
}

const std::vector<LightField::Point>& LightField::eyes() const {
  return content_->eyes;
}

LightField::View LightField::from(const Point& eye) const {
  const CompactModel& model = content_->model;
  const Eigen::Vector3d place = Eigen::Vector3d(eye[0], eye[1], eye[2]) - model.mesh->origin;
  return View(std::make_unique<const View::State>(
      View::State{content_, content_->light_field.coefficients_for(place, one_after_the_other),
                  model.exposure.at(place), brightest_drawn(model)}));
}

LightField::View::View(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightField::View::View(View&&) noexcept = default;
LightField::View& LightField::View::operator=(View&&) noexcept = default;
LightField::View::~View() = default;

LightField::Colour LightField::View::shade(std::uint32_t triangle, float u, float v) const {
  const Content& content = *state_->content;
  if (triangle >= content.model.mesh->triangles.size())
    throw std::out_of_range("sheen::LightField: there is no triangle " + std::to_string(triangle));
  const TrianglePlace place = content.light_field.shapes().place(triangle);
  const SurfacePatch* const patch = content.light_field.patches()[place.patch].get();
  if (!patch || patch->rank() == 0) return {};
  const LatticeStencil stencil = lattice_stencil(content.model.maps->resolution(triangle), u, v);
  const Eigen::Vector3f encoded = patch->colour(place, stencil, state_->coefficients, u, v).cwiseMin(state_->brightest);
  Colour radiance;
  for (int c = 0; c < 3; ++c) radiance[std::size_t(c)] = state_->exposure * srgb_decode(encoded[c]);
  return radiance;
}

}  // namespace sheen
