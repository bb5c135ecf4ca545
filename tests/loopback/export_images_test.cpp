// SPDX-License-Identifier: Apache-2.0
// Photographs and sessions as data sets of other programs: what is written builds the model that they build.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/datasets/dataset.h"
#include "common/geometry/mesh.h"
#include "common/image/image_io.h"
#include "common/session/session.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;

class ExportImages : public ::testing::Test {
 protected:
  ExportImages() { data_.write(); }

  Outcome export_to(const fs::path& source, const Words& words) const {
    return run_to_end(reconstructor({"export", source}) + words);
  }
  Json built(const fs::path& source) const {
    const fs::path report = temp_.path() / "built.json";
    expect_outcome(run_to_end(reconstructor({"build", source, "--mesh", data_.mesh(), "--config", data_.scene(),
                                             "--no-refine", "--json", report})),
                   0, {});
    return Json::parse(read_file(report));
  }
  void expect_builds_the_same(const fs::path& source, const fs::path& exported, double db) const {
    const Json a = built(source), b = built(exported);
    for (const char* count : {"accepted", "held_out"}) EXPECT_EQ(a["frames"][count], b["frames"][count]) << count;
    EXPECT_NEAR(a["held_out"]["psnr_db"].get<double>(), b["held_out"]["psnr_db"].get<double>(), db) << exported;
  }
  /// A session with the images of the data set; hostile names.
  fs::path session(const std::vector<std::string>& names) const {
    const fs::path folder = temp_.path() / "session";
    const Dataset dataset = load_dataset(data_.folder);
    Session session = Session::create(folder);
    for (std::size_t i = 0; i < dataset.views.size(); ++i) {
      Capture capture = read_capture(dataset, i);
      capture.purpose = Purpose::kUnspecified;
      capture.name = names[i % names.size()];
      session.append(capture);
    }
    return folder;
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data"};
  const fs::path out_ = temp_.path() / "out", colmap_ = temp_.path() / "colmap";
};

TEST_F(ExportImages, ADataSetIsReadAgainAsItWas) {
  const fs::path report = temp_.path() / "export.json";
  expect_outcome(
      export_to(data_.folder, {"--transforms", out_, "--colmap", colmap_, "--mesh", data_.mesh(), "--json", report}), 0,
      {"16 images, 2 of them held out, 162 points"});
  const Json said = Json::parse(read_file(report));
  EXPECT_EQ(said["transforms"]["images"], 16);
  EXPECT_EQ(said["colmap"]["held_out"], 2);

  const Dataset before = load_dataset(data_.folder);
  for (const fs::path& folder : {out_, colmap_}) {
    const Dataset after = load_dataset(folder);
    ASSERT_EQ(after.views.size(), before.views.size());
    EXPECT_EQ(after.account.masks, 16u);
    EXPECT_TRUE(after.account.unused.empty());
    for (std::size_t i = 0; i < before.views.size(); ++i) {
      const DatasetView &a = before.views[i], &b = after.views[i];
      EXPECT_EQ(a.purpose, b.purpose) << b.name;
      EXPECT_EQ(a.camera, b.camera);
      EXPECT_NEAR((a.camera_from_object.matrix() - b.camera_from_object.matrix()).norm(), 0, 1e-14);
      EXPECT_EQ(read_file(a.image_path), read_file(b.image_path)) << "photographs are not coded again";
      EXPECT_EQ(read_mask(*a.mask_path), read_mask(*b.mask_path));
    }
    expect_builds_the_same(data_.folder, folder, 1e-3);
  }
  const Json transforms = Json::parse(read_file(out_ / "transforms.json"));
  EXPECT_EQ(transforms["frames"][3]["file_path"], "images/1003.png");
  EXPECT_EQ(transforms["frames"][3]["mask_path"], "masks/1003.png");
  EXPECT_TRUE(fs::exists(out_ / transforms["ply_file_path"].get<std::string>()));
  EXPECT_TRUE(fs::exists(colmap_ / "images/1003.png"));
  EXPECT_TRUE(fs::exists(colmap_ / "masks/1003.png.png"));
  EXPECT_EQ(read_file(colmap_ / "sparse/0/test.txt"), "1004.png\n1012.png\n");
  EXPECT_GT(fs::file_size(colmap_ / "sparse/0/points3D.bin"), 162 * 43u);
}

TEST_F(ExportImages, ASessionWithWhateverNames) {
  const fs::path from =
      session({"left frame 1", "../../x", "/etc/passwd", "images/a.png", "images/a.jpg", "a b#c", "frame 1", "A.png"});
  {
    Session open = Session::open_to_withdraw(from);
    open.set_withdrawn(2, true);
  }
  expect_outcome(export_to(from, {"--transforms", out_, "--colmap", colmap_}), 0,
                 {"15 images, 2 of them held out, 0 points", "--mesh FILE"});
  EXPECT_EQ(load_dataset(out_).views.size(), 15u);
  for (const auto& entry : fs::directory_iterator(out_ / "images"))
    EXPECT_EQ(entry.path().filename().string().find_first_of(" #"), std::string::npos) << entry.path();
  EXPECT_FALSE(fs::exists(temp_.path() / "x.png"));
  for (const fs::path& folder : {out_, colmap_}) expect_builds_the_same(from, folder, 1e-3);
}

TEST_F(ExportImages, WithoutTheLens) {
  Json json = Json::parse(read_file(data_.folder / "transforms.json"));
  json["camera_model"] = "OPENCV";
  json["k1"] = -0.5;
  write_file(data_.folder / "transforms.json", json.dump());
  expect_outcome(export_to(data_.folder, {"--colmap", colmap_, "--undistort"}), 0, {"16 images"});
  EXPECT_THAT(read_file(colmap_ / "sparse/0/cameras.txt"), HasSubstr("PINHOLE 160 120"));
  const Dataset before = load_dataset(data_.folder), after = load_dataset(colmap_);
  const ImageU8 mask = read_mask(*after.views[0].mask_path), full = read_mask(*before.views[0].mask_path);
  std::size_t object = 0, object_before = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) object += mask.data()[i] != 0, object_before += full.data()[i] != 0;
  EXPECT_GT(object, object_before) << "a barrel draws towards the middle; undone, the ball is larger";
  EXPECT_LT(object, object_before * 6 / 5);
}

TEST_F(ExportImages, NothingIsOverwrittenAndWrongUseIsTold) {
  fs::create_directories(out_);
  write_file(out_ / "mine.txt", "mine");
  expect_outcome(export_to(data_.folder, {"--transforms", out_}), 1, {"out"});
  EXPECT_EQ(read_file(out_ / "mine.txt"), "mine");
  EXPECT_FALSE(fs::exists(out_ / "transforms.json"));
  expect_outcome(export_to(data_.folder, {}), 2, {"--transforms", "--gltf"});
  expect_outcome(export_to(data_.folder, {"--transforms", colmap_, "--gltf", temp_.path() / "a.glb"}), 2,
                 {"of a model"});
  expect_outcome(export_to(data_.folder, {"--undistort", "--gltf", temp_.path() / "a.glb"}), 2, {"--undistort"});
  expect_outcome(export_to(data_.folder, {"--colmap", colmap_, "--mesh", temp_.path() / "none.ply"}), 1, {"none.ply"});
  const fs::path of_a = session({"a"});
  for (const Words& file : {Words{"--gltf", temp_.path() / "a.glb"}, Words{"--page", temp_.path() / "page"}})
    expect_outcome(export_to(of_a, file), 2, {"is a session", "session/model"});
  const fs::path model = temp_.path() / "model";
  expect_outcome(run_to_end(reconstructor({"build", data_.folder, "--mesh", data_.mesh(), "--config", data_.scene(),
                                           "--no-refine", "--out", model, "--loss", "0dB"})),
                 0, {});
  expect_outcome(export_to(model, {"--colmap", colmap_}), 2, {"is a model", "session"});
  expect_outcome(export_to(temp_.path() / "nowhere", {"--colmap", colmap_}), 1, {"nowhere"});
  EXPECT_FALSE(fs::exists(colmap_)) << "nothing is left of what failed";
}

}  // namespace
}  // namespace sheen::testing
