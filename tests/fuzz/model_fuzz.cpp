// SPDX-License-Identifier: Apache-2.0
// Whatever the files of a saved model hold: a model that can be looked at and that, saved again, opens as the same, or
// a FileError.
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/surface/view_hemisphere.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::Input;
using Json = nlohmann::json;

/// A tetrahedron: a patch of rank 0, of rank 1 and of rank 2 with drift; of the last one nothing is known.
SurfaceLightFieldSnapshot small_model() {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}, {-0.1f, -0.1f, -0.1f}};
  mesh->triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>{2, 3, 4, 2});
  auto reflection = std::make_shared<ReflectionDrift>();
  reflection->coefficients.setConstant(0.1f);
  const auto shapes = std::make_shared<const PatchShapes>(patch_shapes(*mesh, *maps, {0, 1, 2, 3}));
  SurfaceLightFieldSnapshot::Patches data(4);
  for (int p = 0; p < 3; ++p) {
    const int rank = p, views = 1 + p;
    const PatchShape& shape = shapes->patches[static_cast<std::size_t>(p)];
    auto patch = std::make_shared<PatchSnapshot>();
    patch->basis = Eigen::MatrixXf(Eigen::MatrixXf::Constant(3 * Eigen::Index{shape.samples}, rank, 0.2f));
    patch->shown.assign(shape.samples, 200);
    for (const std::uint32_t v : shape.vertices) {
      VertexInterpolant& at = patch->vertices.emplace_back();
      auto from = std::make_shared<VertexViews>();
      at.weights = Eigen::MatrixXf(Eigen::MatrixXf::Constant(views, rank, 0.3f));
      at.mean = Eigen::VectorXf::Constant(rank, 0.5f);
      from->frame = hemisphere_frame(mesh->vertices[v].normalized());
      from->directions.resize(3, views);
      for (int k = 0; k < views; ++k)
        from->directions.col(k) = (mesh->vertices[v] * 10 + Eigen::Vector3f(0, 0, 0.1f * k)).normalized();
      from->reliability = Eigen::VectorXf::Constant(views, 0.5f);
      if (p == 2) {
        at.drift = Eigen::VectorXf::Constant(rank, 0.1f);
        from->reflection = reflection;
      }
      from->kernel = kViewKernels[v];
      at.views_folded = views;
      at.views = std::move(from);
    }
    data[static_cast<std::size_t>(p)] = std::move(patch);
  }
  return {mesh, maps, shapes, std::move(data), 1};
}

struct Files {
  std::string description, mesh;
  ExrFile maps;
};

const TempFolder& folder() {
  static const TempFolder folder;
  return folder;
}

Files valid_files() {
  const auto path = folder().path() / "valid";
  save_model(small_model(), path, {{"source", "fuzz"}});
  return {read_file(path / "model.json"), read_file(path / "mesh.ply"), read_exr(path / "maps.exr")};
}

/// One of the values of the description becomes another, of whatever type.
void change_a_value(Json& json, Input& in) {
  static const Json kValues[] = {0,
                                 -1,
                                 1,
                                 3,
                                 1e300,
                                 0.5,
                                 255,
                                 256,
                                 60000,
                                 nullptr,
                                 "",
                                 "text",
                                 Json::array(),
                                 Json::object(),
                                 2147483648,
                                 18446744073709551615u,
                                 -9223372036854775807,
                                 true};
  Json* at = &json;
  while (at->is_structured() && !at->empty()) {
    const auto step = static_cast<std::ptrdiff_t>(in.byte() % at->size());
    at = &*std::next(at->begin(), step);
    if (in.byte() % 16 == 0) break;
  }
  *at = kValues[in.byte() % std::size(kValues)];
}

void change_a_part(ExrFile& maps, Input& in) {
  if (maps.parts.empty()) return;
  const std::size_t index = in.byte() % maps.parts.size();
  ExrPart& part = maps.parts[index];
  switch (in.byte() % 8) {
    case 0:
      maps.parts.erase(maps.parts.begin() + static_cast<std::ptrdiff_t>(index));
      break;
    case 1:
      part.image = ImageF(1 + in.byte(), 1 + in.byte() % 8, part.image.channels());
      break;
    case 2:
      part.channels[in.byte() % part.channels.size()] = std::string(1, static_cast<char>('A' + in.byte() % 26));
      break;
    case 3:
      part.precision = ExrPrecision::kHalf;
      break;
    default:
      part.image.data()[in.size16() % part.image.size()] = in.bits<float>();
  }
}

void damage(Files& files, Input& in) {
  switch (in.byte() % 4) {
    case 0:
      return fuzz::damage_once(files.description, in);
    case 1:
      return fuzz::damage_once(files.mesh, in);
    case 2:
      return change_a_part(files.maps, in);
    default:
      Json json = Json::parse(files.description, nullptr, /*allow_exceptions=*/false);
      if (json.is_discarded()) return;
      change_a_value(json, in);
      files.description = json.dump();
  }
}

/// model.json names the mesh by its hash: what hides behind it is looked at, too.
void name_the_mesh(Files& files) {
  Json json = Json::parse(files.description, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return;
  json["mesh_hash"] = content_hash(files.mesh);
  files.description = json.dump();
}

/// What is not a number is the same, too.
bool same(const Eigen::Array3f& a, const Eigen::Array3f& b) {
  return (a == b || (a.isNaN() && b.isNaN())).all();
}

void expect_same_pictures(const SurfaceLightFieldSnapshot& a, const SurfaceLightFieldSnapshot& b) {
  demand(a.mesh().triangles == b.mesh().triangles && a.mesh().vertices == b.mesh().vertices, "another mesh");
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(1, 0.3, 0.2), Eigen::Vector3d(-0.2, -0.4, -0.9)}) {
    const auto shader_a = a.shader_for({eye}), shader_b = b.shader_for({eye});
    for (std::uint32_t t = 0; t < std::min<std::size_t>(a.mesh().triangles.size(), 8); ++t) {
      demand(shader_a->quality(t).reason() == shader_b->quality(t).reason(), "another quality");
      for (const auto& [u, v] : {std::pair(0.2f, 0.3f), std::pair(1.0f, 0.0f), std::pair(0.0f, 0.0f)}) {
        const SurfaceSample point = shader_a->shade(t, u, v), again = shader_b->shade(t, u, v);
        demand(same(point.rgb, again.rgb) && point.state == again.state, "another picture");
      }
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Files kValid = valid_files();
  Input in{{data, size}};
  Files files = kValid;
  const bool right_hash = in.byte() % 4;
  while (in.rest.size() >= 4) damage(files, in);
  if (right_hash) name_the_mesh(files);
  const auto path = folder().path() / "damaged";
  folder().write("damaged/model.json", files.description);
  folder().write("damaged/mesh.ply", files.mesh);
  try {
    write_exr(path / "maps.exr", files.maps);
    const auto model = load_model(path);
    const auto again = folder().path() / "again";
    save_model(*model, again, load_model_metadata(path));
    expect_same_pictures(*model, *load_model(again));
  } catch (const FileError&) {
  }
  return 0;
}
