// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/datasets/dataset.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "common/simulation/light_rig.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

struct Shot {
  std::string name;
  PosedCamera from;
  LightState light;
  Purpose purpose = Purpose::kTraining;
  bool truth = false;
};

/// All images of the grid, then those that judge.
std::vector<Shot> shots_of(const LightRig& rig) {
  const LightRigOptions& o = rig.options();
  const std::size_t centre = rig.cameras().size() / 2;
  std::vector<Shot> shots;
  for (std::size_t v = 0; v < rig.cameras().size(); ++v)
    for (std::size_t l = 0; l < rig.lights().size(); ++l)
      shots.push_back(
          {format("view_%03zu_light_%02zu", v, l), rig.cameras()[v], rig.lights()[l], Purpose::kTraining, v == centre});
  std::vector<std::size_t> judged{centre};
  if (centre != 0) judged.push_back(0);
  for (std::size_t l = 0; l < rig.midway_lights().size(); ++l) {
    for (const std::size_t v : judged)
      shots.push_back(
          {format("view_%03zu_midway_%02zu", v, l), rig.cameras()[v], rig.midway_lights()[l], Purpose::kHeldOut, true});
    if (o.columns > 1)
      shots.push_back({format("between_%03zu_midway_%02zu", centre, l),
                       rig.camera_at((o.columns - 1) / 2 + 0.5, (o.rows - 1) / 2 + (o.rows > 1 ? 0.5 : 0.0)),
                       rig.midway_lights()[l], Purpose::kHeldOut, true});
  }
  return shots;
}

ImageF as_float(const ImageU8& mask) {
  ImageF out(mask.width(), mask.height(), 1);
  std::transform(mask.data(), mask.data() + mask.size(), out.data(), [](std::uint8_t v) { return v / 255.0f; });
  return out;
}

void write_truth(const SimulatedPicture& picture, const fs::path& file) {
  write_exr(file, ExrFile{.parts = {{.name = "radiance", .channels = {"R", "G", "B"}, .image = picture.radiance},
                                    {.name = "reflectance", .channels = {"R", "G", "B"}, .image = picture.reflectance},
                                    {.name = "depth", .channels = {"Z"}, .image = picture.depth},
                                    {.name = "shadow", .channels = {"Y"}, .image = as_float(picture.shadow)}},
                          .attributes = {}});
}

}  // namespace

void write_light_rig(const LightRig& rig, const fs::path& folder, bool truth,
                     const std::function<void(int, int)>& progress) {
  make_folder(folder / "images");
  if (truth) make_folder(folder / "truth");
  save_ply(rig.scene().mesh, folder / "mesh.ply");
  const std::vector<Shot> shots = shots_of(rig);
  std::vector<DatasetView> views;
  for (const Shot& shot : shots) {
    const SimulatedPicture picture = rig.picture(shot.from, shot.light);
    const std::string name = "images/" + shot.name + ".png";
    write_png(folder / name, to_srgb8(picture.radiance));
    if (truth && shot.truth) write_truth(picture, folder / "truth" / (shot.name + ".exr"));
    views.push_back({.name = name,
                     .image_path = folder / name,
                     .camera = shot.from.camera,
                     .camera_from_object = shot.from.camera_from_object,
                     .light = shot.light,
                     .purpose = shot.purpose});
    if (progress) progress(static_cast<int>(views.size()), static_cast<int>(shots.size()));
  }
  write_transforms(folder / "transforms.json", views);
}

}  // namespace sheen
