// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/commands/exports.h"
#include "reconstructor/exchange/mesh_files.h"
#include "reconstructor/exchange/usdz_file.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {
namespace {

constexpr int kMostSide = 4096;  ///< texels; what every viewer takes

}  // namespace

nlohmann::json export_surface(const ModelSnapshot& model, const std::string& name, const SurfaceFiles& files) {
  for (const std::filesystem::path& file : {files.gltf, files.ply, files.obj, files.usdz})
    if (!file.empty()) check_writable(file);
  const std::shared_ptr<const ModelSnapshot> filled = model.filled();
  const std::optional<AverageLook> look = filled->average_look();
  if (!look)
    throw ConfigError(
        name + ": has no surface that is seen from all sides, so there is none for --gltf, --ply, --obj or --usdz");
  const auto view = opening_view(model.cameras(), bounding_sphere(model.mesh()).centre);
  const Eigen::Matrix3f turn = upright(view ? view->up : Eigen::Vector3d::UnitZ());
  nlohmann::json report;
  const auto wrote = [&](const char* kind, const std::filesystem::path& file, const TexturedMesh& textured) {
    std::printf("%s written: %zu triangles, a texture of %d x %d\n", file.c_str(), textured.mesh.triangles.size(),
                textured.picture.width(), textured.picture.height());
    report[kind] = {{"path", file.string()},
                    {"bytes", std::filesystem::file_size(file)},
                    {"triangles", textured.mesh.triangles.size()},
                    {"texture", textured.picture.width()}};
  };
  if (!files.gltf.empty() || !files.ply.empty() || !files.obj.empty()) {
    const TexturedMesh textured = textured_mesh(model.mesh(), *look, kMostSide);
    if (!files.gltf.empty()) {
      write_glb(files.gltf, textured, turn);
      wrote("gltf", files.gltf, textured);
    }
    if (!files.ply.empty()) {
      write_textured_ply(files.ply, textured);
      wrote("ply", files.ply, textured);
    }
    if (!files.obj.empty()) {
      write_obj(files.obj, textured);
      wrote("obj", files.obj, textured);
    }
  }
  if (!files.usdz.empty()) {
    const TexturedMesh textured = textured_mesh(model.mesh(), *look, kMostUsdzSide);
    write_usdz(files.usdz, textured, turn);
    wrote("usdz", files.usdz, textured);
  }
  return report;
}

}  // namespace sheen
