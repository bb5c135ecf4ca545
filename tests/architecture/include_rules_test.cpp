// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/architecture/include_rules.h"

namespace sheen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> verdict(const std::string& file, const std::string& target) {
  return broken_include_rules({{file, 1, target}});
}

TEST(IncludeRules, HoldInThisRepository) {
  const std::vector<Include> includes = includes_below(SHEEN_SOURCE_DIR);
  ASSERT_GT(includes.size(), 100U) << "the sources were not found";
  std::string all;
  for (const std::string& broken : broken_include_rules(includes)) all += broken + "\n";
  EXPECT_EQ(all, "");
}

TEST(IncludeRules, EachForbidsWhatItIsThereFor) {
  const std::vector<std::pair<std::string, std::string>> violations = {
      {"common/camera/camera.h", "tracker/pose/pose_solver.h"},
      {"common/simulation/rig.cpp", "reconstructor/capture/capture_report.h"},
      {"tracker/tracking_loop.cpp", "reconstructor/surface/map_layout.h"},
      {"reconstructor/capture/capture_loop.cpp", "tracker/tracking_loop.h"},
      {"reconstructor/capture/capture_report.cpp", "tests/support/matchers.h"},
      {"reconstructor/numerics/online_svd.cpp", "common/camera/camera.h"},
      {"reconstructor/numerics/online_svd.cpp", "tbb/parallel_for.h"},
      {"reconstructor/surface/map_layout.h", "reconstructor/models/appearance_model.h"},
      {"reconstructor/surface/map_layout.h", "reconstructor/evaluation/held_out.h"},
      {"reconstructor/models/appearance_model.h", "reconstructor/render/ray_painter.h"},
      {"reconstructor/models/surface_light_field/quality.h", "reconstructor/commands/commands.h"},
      {"reconstructor/models/irradiance_field/lamp.cpp", "reconstructor/models/surface_light_field/quality.h"},
      {"reconstructor/models/appearance_model.h", "reconstructor/models/surface_light_field/quality.h"},
      {"reconstructor/render/gl/window.cpp", "reconstructor/capture/capture_loop.h"},
      {"reconstructor/render/gl/window.cpp", "reconstructor/models/surface_light_field/snapshot.h"},
      {"reconstructor/capture/capture_loop.cpp", "reconstructor/models/surface_light_field/kind.h"},
      {"reconstructor/commands/evaluate.cpp", "reconstructor/models/surface_light_field/snapshot.h"},
      {"reconstructor/models/model_registry.cpp", "reconstructor/models/surface_light_field/snapshot.h"},
      {"reconstructor/capture/capture_loop.cpp", "reconstructor/studies/figure.h"},
      {"reconstructor/scene/scene_config.cpp", "reconstructor/capture/capture_loop.h"},
      {"reconstructor/monitor/monitor_server.h", "reconstructor/capture/reconstruction.h"},
      {"reconstructor/capture/capture_loop.cpp", "reconstructor/commands/commands.h"},
      {"reconstructor/capture/saved_model.cpp", "pybind11/pybind11.h"},
      {"reconstructor/library/sheen/light_field.h", "Eigen/Core"},
      {"reconstructor/library/light_field.cpp", "reconstructor/models/model_snapshot.h"},
      {"reconstructor/models/surface_light_field/quality.cpp", "embree3/rtcore.h"},
      {"reconstructor/commands/build.cpp", "CLI/CLI.hpp"},
      {"tracker/tracking_loop.cpp", "proto/capture.pb.h"},
      {"tests/loopback/link_test.cpp", "proto/capture.pb.h"},
      {"reconstructor/capture/capture_loop.cpp", "zmq.hpp"},
      {"common/session/session.h", "sqlite3.h"},
      {"tracker/sources/aravis_devices.h", "arv.h"},
      {"reconstructor/surface/view_hemisphere.h", "opencv2/imgproc.hpp"},
      {"common/stage/stage_layout.h", "common/base/json_fields.h"},
      {"common/image/raw_image.h", "common/camera/camera.h"},
      {"common/image/image_codec.h", "common/link/wire.h"},
      {"common/link/wire.h", "common/session/session.h"},
      {"common/session/session.h", "common/datasets/dataset.h"},
      {"common/camera/camera.h", "common/loose.h"},
      {"common/registration/placement.cpp", "common/datasets/dataset.h"},
      {"common/stage/stage_layout.cpp", "common/camera/camera.h"},
      {"tracker/pose/pose_solver.cpp", "ceres/ceres.h"},
      {"reconstructor/coding/context_coder.h", "reconstructor/numerics/fixed_point.h"},
      {"reconstructor/refinement/mesh_refinement.h", "reconstructor/models/appearance_model.h"},
      {"reconstructor/models/surface_light_field/patch_set.cpp", "reconstructor/render/ray_painter.h"},
      {"reconstructor/models/surface_light_field/effort_levels.cpp", "reconstructor/effort/effort_control.h"},
      {"reconstructor/monitor/metrics.cpp", "reconstructor/models/model_snapshot.h"},
      {"reconstructor/evaluation/held_out.cpp", "reconstructor/effort/effort_control.h"},
      {"reconstructor/effort/effort_probe.cpp", "reconstructor/capture/reconstruction.h"},
      {"reconstructor/studies/figure.cpp", "reconstructor/capture/capture_loop.h"},
  };
  for (const auto& [file, target] : violations)
    EXPECT_THAT(verdict(file, target), testing::Not(IsEmpty())) << file << " includes " << target;
}

TEST(IncludeRules, AllowWhatTheLayersAreFor) {
  const std::vector<std::pair<std::string, std::string>> fine = {
      {"common/link/wire.cpp", "proto/capture.pb.h"},
      {"common/link/transport.cpp", "zmq.hpp"},
      {"common/geometry/ray_scene.cpp", "embree3/rtcore.h"},
      {"common/base/command_line.cpp", "CLI/CLI.hpp"},
      {"common/session/session.cpp", "sqlite3.h"},
      {"reconstructor/numerics/online_svd.h", "Eigen/Core"},
      {"reconstructor/numerics/online_svd.h", "vector"},
      {"reconstructor/models/surface_light_field/quality.h", "reconstructor/models/surface_light_field/snapshot.h"},
      {"reconstructor/models/surface_light_field/quality.h", "reconstructor/models/appearance_model.h"},
      {"reconstructor/render/ray_painter.h", "reconstructor/models/appearance_model.h"},
      {"reconstructor/models/model_registry.cpp", "reconstructor/models/surface_light_field/kind.h"},
      {"reconstructor/models/surface_light_field/gl/basis_store.h", "reconstructor/render/gl/gl_objects.h"},
      {"reconstructor/studies/figure.h", "reconstructor/models/surface_light_field/snapshot.h"},
      {"reconstructor/commands/tradeoff.cpp", "reconstructor/studies/tradeoff.h"},
      {"reconstructor/main.cpp", "reconstructor/commands/commands.h"},
      {"reconstructor/commands/build.cpp", "reconstructor/commands/commands.h"},
      {"reconstructor/capture/capture_report.h", "nlohmann/json_fwd.hpp"},
  };
  for (const auto& [file, target] : fine) EXPECT_THAT(verdict(file, target), IsEmpty()) << file << " <- " << target;
}

TEST(IncludeRules, AreFoundInATreeOnDisk) {
  namespace fs = std::filesystem;
  const fs::path root = fs::path(testing::TempDir()) / "include_rules_tree";
  fs::remove_all(root);
  fs::create_directories(root / "common");
  fs::create_directories(root / "reconstructor" / "numerics");
  std::ofstream(root / "common" / "loose.h") << "#pragma once\n#include \"reconstructor/capture/capture_report.h\"\n";
  std::ofstream(root / "reconstructor" / "numerics" / "svd.cpp")
      << "#include <Eigen/SVD>\n// #include \"common/camera/camera.h\"\n  #  include <opencv2/core.hpp>  // why not\n";
  std::ofstream(root / "common" / "notes.txt") << "#include \"tracker/main.h\"\n";

  EXPECT_THAT(includes_below(root), SizeIs(3));
  std::vector<std::string> broken = broken_include_rules(includes_below(root));
  std::sort(broken.begin(), broken.end());
  EXPECT_THAT(broken, ElementsAre(HasSubstr("common/loose.h:2 includes reconstructor/capture/capture_report.h"),
                                  HasSubstr("reconstructor/numerics/svd.cpp:3 includes opencv2/core.hpp")));
  fs::remove_all(root);
}

}  // namespace
}  // namespace sheen
