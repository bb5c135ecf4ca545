// SPDX-License-Identifier: Apache-2.0
// A folder of photographs and nothing else: `shape` and `build` have COLMAP find where they were taken from. The main
// path needs COLMAP, and is passed over where it is not installed.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/child_process.h"
#include "common/base/files.h"
#include "common/base/order_statistics.h"
#include "common/datasets/dataset.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/patience.h"
#include "tests/support/process.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using Words = std::vector<std::string>;

constexpr std::chrono::seconds kPatience{150 * kPatienceFactor};
constexpr double kRadius = 0.05, kDistance = 0.2;
constexpr int kPhotographs = 24;

/// In [0, 1], the same for the same cell of a lattice.
double hashed(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u ^
                    static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fu ^
                    static_cast<std::uint64_t>(z) * 0x165667b19e3779f9u;
  h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9u;
  return static_cast<double>((h ^ (h >> 32)) >> 11) * 0x1p-53;
}

/// Smooth noise whose grains are `grain` metres wide: corners everywhere, no two alike.
double noise(const Eigen::Vector3d& p, double grain) {
  const Eigen::Vector3d q = p / grain, low = q.array().floor(), f = q - low;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i at = low.cast<int>() + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
    double weight = 1;
    for (int a = 0; a < 3; ++a) weight *= corner >> a & 1 ? f[a] : 1 - f[a];
    sum += weight * hashed(at.x(), at.y(), at.z());
  }
  return sum;
}

analytic::Scene speckled_ball() {
  return {analytic::sphere(kRadius),
          analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
            const double v = 0.6 * noise(p, 0.003) + 0.4 * noise(p + Eigen::Vector3d(7, 7, 7), 0.009);
            return Eigen::Vector3d(0.2 + 0.7 * v, 0.15 + 0.7 * v, 0.1 + 0.6 * v);
          }),
          {0, 0, 0}};
}

/// Round the ball, all at its height but for a slight wave.
Rigid3 station(int i) {
  const double angle = 2 * M_PI * i / kPhotographs;
  return look_at({kDistance * std::cos(angle), kDistance * std::sin(angle), 0.03 * std::sin(3 * angle)},
                 Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
}

std::string name_of(int i) {
  return "photo_" + std::to_string(100 + i) + ".png";
}

void photograph(const fs::path& folder, const analytic::Scene& scene, int count) {
  const Camera camera{.width = 320, .height = 240, .fx = 400, .fy = 400, .cx = 159.5, .cy = 119.5};
  fs::create_directories(folder);
  for (int i = 0; i < count; ++i) {
    const ImageF linear = analytic::picture(scene, camera, station(i));
    ImageU8 picture(camera.width, camera.height, 3);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        for (int c = 0; c < 3; ++c)
          picture.at(x, y, c) = static_cast<std::uint8_t>(std::lround(255 * srgb_encode(linear.at(x, y, c))));
    write_png(folder / name_of(i), picture);
  }
}

void expect_end(Process& process, int status, const Words& words) {
  const auto end = process.wait(kPatience);
  ASSERT_TRUE(end) << process.output();
  EXPECT_EQ(end->status, status) << process.output();
  for (const std::string& word : words) EXPECT_NE(process.output().find(word), std::string::npos) << process.output();
}

class PlainPhotographs : public ::testing::Test {
 protected:
  const TempFolder temp_;
  const fs::path photos_ = temp_.path() / "photos", posed_ = temp_.path() / "photos.posed";

  void expect_shape(int status, const Words& says, const Words& more = {}, const ProcessOptions& options = {}) const {
    Words command{SHEEN_RECONSTRUCTOR, "shape", photos_, "--out", temp_.path() / "mesh.ply"};
    command.insert(command.end(), more.begin(), more.end());
    Process process(command, options);
    expect_end(process, status, says);
  }
};

/// Each station's way to the next as the poses have it, compared with the truth.
void expect_stations(const std::vector<DatasetView>& views) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < views.size(); ++i) {
    distances.push_back(camera_centre(views[i].camera_from_object).norm());
    const std::size_t next = (i + 1) % views.size();
    const Eigen::Quaterniond found =
        views[next].camera_from_object.rotation * views[i].camera_from_object.rotation.conjugate();
    const Eigen::Quaterniond truth = station(int(next)).rotation * station(int(i)).rotation.conjugate();
    EXPECT_LT(found.angularDistance(truth), 0.04) << views[i].name;  // of a step of 0.26
  }
  // A ball alone leaves open how far a longer lens stands away: COLMAP's length is off by a tenth.
  EXPECT_NEAR(median(distances), kDistance, 0.15 * kDistance);
}

TEST_F(PlainPhotographs, GiveAShapeOfTheMeasuredSizeAndAreKept) {
  if (program_in_path("colmap").empty()) GTEST_SKIP() << "COLMAP is not installed";
  photograph(photos_, speckled_ball(), kPhotographs);
  const fs::path report = temp_.path() / "report.json";
  expect_shape(0, {"placed 24 of 24 photographs", "photos.posed", "greatest length of the shape is 0.1 m"},
               {"--object-size", "10cm", "--json", report});
  const Json told = Json::parse(read_file(report))["photographs"];
  EXPECT_EQ(told["placed"], kPhotographs);
  EXPECT_TRUE(told["size_known"]);
  expect_stations(load_cameras(posed_ / "transforms.json"));
  EXPECT_FALSE(fs::exists(photos_ / "sparse"));
  EXPECT_TRUE(fs::exists(temp_.path() / "photos.posed.log"));

  // Once more without COLMAP: the poses are those that were found.
  const ProcessOptions nothing_installed{.environment = {{"PATH", temp_.path()}}, .file_bytes = {}};
  expect_shape(0, {"COLMAP has placed 24 of 24 photographs"}, {}, nothing_installed);
  // Not of other photographs.
  fs::remove(photos_ / name_of(0));
  expect_shape(1, {"not installed"}, {}, nothing_installed);
}

TEST_F(PlainPhotographs, WithoutColmapAreToldWhatToDo) {
  photograph(photos_, speckled_ball(), 4);
  expect_shape(1, {"not installed", "sudo apt install colmap", "colmap exhaustive_matcher", "colmap mapper"}, {},
               {.environment = {{"PATH", temp_.path()}}, .file_bytes = {}});
  EXPECT_FALSE(fs::exists(posed_));
}

TEST_F(PlainPhotographs, ThatAreTooFewAreRefused) {
  fs::create_directories(photos_);
  expect_shape(1, {"photos", "transforms.json", "photographs"});
  photograph(photos_, speckled_ball(), 2);
  expect_shape(1, {"holds 2 photographs", "20 at least"});
}

TEST_F(PlainPhotographs, WithNothingInCommonAreRefused) {
  if (program_in_path("colmap").empty()) GTEST_SKIP() << "COLMAP is not installed";
  const Eigen::Vector3d grey(0.2, 0.2, 0.2);
  photograph(photos_, {analytic::sphere(kRadius), [&](const auto&, const auto&) { return grey; }, {0, 0, 0}}, 4);
  expect_shape(1, {"too little in common", "photos.posed.log"});
  EXPECT_FALSE(fs::exists(posed_));
  EXPECT_NE(read_file(temp_.path() / "photos.posed.log").find("Feature extraction"), std::string::npos);
}

TEST_F(PlainPhotographs, EndAtASignalWithColmap) {
  if (program_in_path("colmap").empty()) GTEST_SKIP() << "COLMAP is not installed";
  photograph(photos_, speckled_ball(), kPhotographs);
  Process process({SHEEN_RECONSTRUCTOR, "build", photos_});
  const fs::path log = temp_.path() / "photos.posed.log";
  for (int i = 0; i < 2000 && !(fs::exists(log) && read_file(log).find("Processed file") != std::string::npos); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  process.signal(SIGINT);
  expect_end(process, 1, {"stopped while COLMAP worked"});
  EXPECT_FALSE(fs::exists(posed_));
  for (const auto& entry : fs::directory_iterator(temp_.path()))
    EXPECT_FALSE(entry.path().filename().string().ends_with(".part")) << entry.path();
  const auto said = fs::file_size(log);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(fs::file_size(log), said) << "COLMAP goes on";
}

TEST_F(PlainPhotographs, DoNotTakeWhatDoesNotBelongToThem) {
  photograph(photos_, speckled_ball(), 3);
  Process process({SHEEN_RECONSTRUCTOR, "build", photos_, "--mesh", "some.ply"});
  expect_end(process, 2, {"--mesh", "leave it out"});
  expect_shape(2, {"--object-size", "12cm"}, {"--object-size", "large"});
  fs::create_directories(posed_);
  fs::create_directories(posed_ / "mine");
  expect_shape(1, {"photos.posed", "another folder"});
}

}  // namespace
}  // namespace sheen::testing
