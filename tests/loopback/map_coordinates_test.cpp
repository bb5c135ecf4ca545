// SPDX-License-Identifier: Apache-2.0
// Data sets whose coordinates are those of a map, in which single precision holds no object: all commands do as they do
// with the same images near zero, and what they write stands in the map.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/datasets/dataset.h"
#include "common/geometry/mesh.h"
#include "common/image/image_io.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const Eigen::Vector3d kMap(500'123.4, 4'649'776.5, 312.75);

/// The ball's photographs near zero, and the same in the map.
class MapCoordinates : public ::testing::Test {
 protected:
  MapCoordinates() {
    near_.write();
    fs::copy(near_.folder, map_, fs::copy_options::recursive);
    Json json = Json::parse(read_file(map_ / "transforms.json"));
    for (Json& frame : json["frames"])
      for (std::size_t k = 0; k < 3; ++k)
        frame["transform_matrix"][k][3] = frame["transform_matrix"][k][3].get<double>() + kMap[Eigen::Index(k)];
    write_file(map_ / "transforms.json", json.dump());
    std::string obj;
    const Mesh ball = load_mesh(near_.mesh()).mesh;
    for (const Eigen::Vector3f& v : ball.vertices) {
      const Eigen::Vector3d in_map = v.cast<double>() + kMap;
      obj += format("v %.10f %.10f %.10f\n", in_map.x(), in_map.y(), in_map.z());
    }
    for (const auto& [a, b, c] : ball.triangles) obj += format("f %u %u %u\n", a + 1, b + 1, c + 1);
    write_file(mesh_, obj);
  }

  Json build(const fs::path& data, const fs::path& mesh, const fs::path& out, const Words& more = {}) const {
    const fs::path report = temp_.path() / "built.json";
    expect_outcome(run_to_end(reconstructor({"build", data, "--mesh", mesh, "--config", near_.scene(), "--out", out,
                                             "--json", report}) +
                              more),
                   0, {});
    return Json::parse(read_file(report));
  }
  double evaluated_db(const fs::path& model, const fs::path& data, const Words& more = {}) const {
    const fs::path report = temp_.path() / "scores.json";
    expect_outcome(run_to_end(reconstructor({"evaluate", model, data, "--json", report}) + more), 0, {});
    return Json::parse(read_file(report))["object"]["psnr_db"];
  }
  fs::path rendered(const fs::path& model, const fs::path& data, const std::string& name) const {
    expect_outcome(run_to_end(reconstructor(
                       {"render", model, "--cameras", data / "transforms.json", "--out", temp_.path() / name})),
                   0, {"views rendered"});
    return temp_.path() / name / "1003.png";
  }

  const TempFolder temp_;
  const BallDataset near_{.folder = temp_.path() / "near"};
  const fs::path map_ = temp_.path() / "map", mesh_ = temp_.path() / "map" / "ball.obj";
};

double mean_difference(const fs::path& a, const fs::path& b) {
  const RawImage first = read_image(a), second = read_image(b);
  EXPECT_EQ(first.bytes.size(), second.bytes.size());
  double sum = 0;
  for (std::size_t i = 0; i < first.bytes.size(); ++i) sum += std::abs(int(first.bytes[i]) - int(second.bytes[i]));
  return sum / static_cast<double>(first.bytes.size());
}

TEST_F(MapCoordinates, AreBuiltJudgedAndRenderedAsNearZero) {
  const fs::path near_model = temp_.path() / "near.slf";
  const double near_db = build(near_.folder, near_.mesh(), near_model)["held_out"]["psnr_db"];
  const fs::path near_picture = rendered(near_model, near_.folder, "near_pictures");
  for (const Words& form : {Words{}, Words{"--loss", "0dB"}}) {
    const fs::path model = temp_.path() / (form.empty() ? "map.slf" : "map_folder");
    EXPECT_NEAR(build(map_, mesh_, model, form)["held_out"]["psnr_db"].get<double>(), near_db, 0.02);
    EXPECT_NEAR(evaluated_db(model, map_), near_db, 0.3);
    EXPECT_NEAR(evaluated_db(model, map_, {"--object", mesh_}), near_db, 0.3);
    EXPECT_LT(mean_difference(rendered(model, map_, "map_pictures"), near_picture), 1);
  }
}

TEST_F(MapCoordinates, RefinedMeshAndPosesStandInTheMap) {
  const fs::path refined = temp_.path() / "refined.ply", poses = map_ / "refined.json";
  expect_outcome(run_to_end(reconstructor({"refine", map_, "--mesh", mesh_, "--out", refined, "--poses", poses})), 0,
                 {});
  const Mesh mesh = load_mesh(refined).mesh;
  EXPECT_LT((bounding_sphere(mesh).centre + mesh.origin - kMap).norm(), 0.01);
  const std::vector<DatasetView> given = load_dataset(map_).views, written = load_cameras(poses);
  ASSERT_EQ(written.size(), given.size());
  for (std::size_t i = 0; i < given.size(); ++i)
    EXPECT_LT((camera_centre(written[i].camera_from_object) - camera_centre(given[i].camera_from_object)).norm(), 0.02);
  // What was written is read again as what was given.
  EXPECT_GT(build(map_, refined, temp_.path() / "refined.slf")["held_out"]["psnr_db"].get<double>(), 15);
}

TEST_F(MapCoordinates, AreNoStage) {
  for (const Outcome& outcome :
       {run_to_end(serve(mesh_, temp_.path() / "session", {"--once", "--endpoint", free_address()})),
        run_to_end(tracker({"register", near_.folder, "--mesh", mesh_, "--out", temp_.path() / "placed.ply"}))})
    expect_outcome(outcome, 1, {"ball.obj", "km from the origin", "subtract"});
}

TEST_F(MapCoordinates, BeyondAllMapsAreRefusedWithTheirFrame) {
  Json json = Json::parse(read_file(map_ / "transforms.json"));
  json["frames"][2]["transform_matrix"][1][3] = 1e19;
  const fs::path cameras = temp_.write("cameras.json", json.dump());
  const fs::path model = temp_.path() / "near.slf";
  build(near_.folder, near_.mesh(), model);
  expect_outcome(run_to_end(reconstructor({"render", model, "--cameras", cameras, "--out", temp_.path() / "pictures"})),
                 1, {"cameras.json", "frame 2", "transform_matrix", "10^9 m"});
  write_file(map_ / "transforms.json", json.dump());
  for (const char* command : {"build", "refine"})
    expect_outcome(run_to_end(reconstructor({command, map_, "--mesh", mesh_, "--out", temp_.path() / "out"})), 1,
                   {"transforms.json", "frame 2", "transform_matrix", "10^9 m"});
}

}  // namespace
}  // namespace sheen::testing
