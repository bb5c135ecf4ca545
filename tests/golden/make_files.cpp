// SPDX-License-Identifier: Apache-2.0
// Makes the files of this folder anew, where a version of a format begins: make_files FOLDER. What stands beside them
// comes from the build of one's own machine: read_files --print FILE > FILE.txt.
#include <cmath>
#include <filesystem>
#include <iostream>

#include "common/base/files.h"
#include "common/simulation/light_rig.h"
#include "common/simulation/light_rig_capture.h"
#include "reconstructor/lumigraph_file/encode/lumigraph_encoding.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// A ball that some images show from one side: with vertices that nothing shows, views that were merged, a reflection.
void make_light_field(const std::filesystem::path& file) {
  const analytic::Scene scene{analytic::sphere(0.09), analytic::two_terms(0.05)};
  SurfaceLightFieldOptions options;
  options.hold_out_every = 0;
  options.max_surface_map = 8;
  SurfaceLightField model(std::make_shared<Mesh>(sphere_mesh(0.09f, 2)), options);
  for (int i = 0; i < 40; ++i) {
    const double turn = 2.4 * i, lean = 0.04 * (i % 30);
    const Eigen::Vector3d eye =
        0.5 * Eigen::Vector3d(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
    const double f = 250;
    Capture capture = analytic::capture(scene, {.width = 160, .height = 120, .fx = f, .fy = f, .cx = 79.5, .cy = 59.5},
                                        analytic::towards_origin(eye));
    capture.sequence = static_cast<std::uint64_t>(i) + 1;
    model.ingest(capture);
  }
  model.finish();
  model.snapshot()->filled()->compressed({.bytes = 12e3}).snapshot->save(file, {}, {});
}

void make_irradiance_field(const std::filesystem::path& file) {
  std::vector<Eigen::Vector3d> lights;
  for (int i = 0; i < 20; ++i) {
    const double turn = 2.4 * i, lean = 0.05 * i;
    lights.emplace_back(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
  }
  LambertianRelief().model(lights)->snapshot()->compressed({.bytes = 6000}).snapshot->save(file, {}, {});
}

void make_lumigraph(const std::filesystem::path& file) {
  const LightRig rig({.lights = 2, .columns = 2, .rows = 1, .width = 48, .height = 36});
  IntrinsicLumigraph model(std::make_shared<const Mesh>(rig.scene().mesh), IntrinsicLumigraphOptions());
  std::uint64_t sequence = 0;
  for (const PosedCamera& camera : rig.cameras())
    for (const LightState& light : rig.lights())
      model.ingest(rig_capture(camera, light, rig.picture(camera, light).radiance, ++sequence));
  const auto snapshot = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(model.snapshot());
  write_file(file, encode_lumigraph(*snapshot->data()));
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_files FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  sheen::make_light_field(folder / "sphere.slf");
  sheen::make_irradiance_field(folder / "relief.rif");
  sheen::make_lumigraph(folder / "views.ilg");
}
