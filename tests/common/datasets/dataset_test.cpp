// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/dataset.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"
#include "support/expect_error.h"
#include "support/shared_data.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

/// Three views with masks, one held out, one through a distorting lens.
std::vector<DatasetView> make_dataset(const TempFolder& folder) {
  fs::create_directories(folder.path() / "images");
  fs::create_directories(folder.path() / "masks");
  std::vector<DatasetView> views;
  for (int i = 0; i < 3; ++i) {
    DatasetView view;
    view.name = "images/" + std::to_string(i) + ".png";
    view.image_path = folder.path() / view.name;
    view.mask_path = folder.path() / "masks" / (std::to_string(i) + ".png");
    view.camera = {.width = 12 + i, .height = 8, .fx = 20, .fy = 21.5, .cx = 5.25, .cy = 3.75};
    if (i == 1) view.camera.distortion = {-0.1, 0.02, 0.001, 0.002, 0.003};
    view.camera_from_object = look_at({1.0 + i, 2, 3}, {0, 0.1, 0}, {0, 0, 1});
    view.purpose = i == 2 ? Purpose::kHeldOut : Purpose::kTraining;
    write_png(view.image_path, ImageU8(12 + i, 8, 3, std::uint8_t(50 * i)));
    write_png(*view.mask_path, ImageU8(12 + i, 8, 1, 255));
    views.push_back(view);
  }
  return views;
}

void expect_same_views(const std::vector<DatasetView>& a, const std::vector<DatasetView>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_TRUE(fs::equivalent(a[i].image_path, b[i].image_path));
    EXPECT_TRUE(fs::equivalent(*a[i].mask_path, *b[i].mask_path));
    EXPECT_EQ(a[i].purpose, b[i].purpose);
    EXPECT_EQ(a[i].camera.width, b[i].camera.width);
    EXPECT_EQ(a[i].camera.lens, b[i].camera.lens);
    EXPECT_EQ(a[i].camera.distortion, b[i].camera.distortion);
    EXPECT_EQ(a[i].camera.fy, b[i].camera.fy);
    EXPECT_EQ(a[i].camera.cx, b[i].camera.cx);
    EXPECT_NEAR((a[i].camera_from_object.matrix() - b[i].camera_from_object.matrix()).norm(), 0, 1e-12);
  }
}

TEST(Dataset, WrittenAndLoadedAgain) {
  const TempFolder folder;
  auto views = make_dataset(folder);
  write_transforms(folder.path() / "transforms.json", views);
  expect_same_views(load_dataset(folder.path()).views, views);
  expect_same_views(load_dataset(folder.path() / "transforms.json").views, views);

  for (DatasetView& view : views) {
    view.camera.lens = LensModel::kFisheye;
    view.camera.distortion = {0.1, 0.2, 0.3, 0.4, 0};
  }
  write_transforms(folder.path() / "transforms.json", views);
  expect_same_views(load_dataset(folder.path()).views, views);

  views[0].camera.lens = LensModel::kOpenCv;  // no common model any more
  views[0].camera.distortion = {};
  write_transforms(folder.path() / "transforms.json", views);
  expect_same_views(load_dataset(folder.path()).views, views);
}

TEST(Dataset, WhatIsWrittenFollowsTheConventionOfOtherTools) {
  const TempFolder folder;
  auto views = make_dataset(folder);
  views[1].camera.distortion = {};
  for (DatasetView& view : views) view.camera.width = 12;
  write_transforms(folder.path() / "transforms.json", views);
  const auto json = nlohmann::json::parse(read_file(folder.path() / "transforms.json"));
  EXPECT_EQ(json.at("camera_model"), "PINHOLE");
  EXPECT_EQ(json.at("cx"), 5.75);
  EXPECT_EQ(json.at("w"), 12);
  EXPECT_EQ(json.at("orientation_override"), "none");
  EXPECT_EQ(json.at("applied_transform").size(), 3u);
  EXPECT_EQ(json.at("test_filenames"), nlohmann::json({"images/2.png"}));
  EXPECT_EQ(json.at("train_filenames").size(), 2u);
  const auto& m = json.at("frames")[0].at("transform_matrix");
  EXPECT_NEAR(m[0][3].get<double>(), 1, 1e-12) << "the eye";
  const Eigen::Vector3d back(m[0][2], m[1][2], m[2][2]);  // OpenGL cameras look along their -z
  EXPECT_NEAR((back - (Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(0, 0.1, 0)).normalized()).norm(), 0, 1e-12);
  EXPECT_GT(m[2][1].get<double>(), 0) << "the image's up is the world's";
  EXPECT_EQ(json.at("frames")[0].at("mask_path"), "masks/0.png");
  expect_error([&] { write_transforms(folder.path() / "t.json", {}); }, {"t.json", "no views"});
  expect_error([&] { write_transforms("/dev/full/t.json", views); }, {"t.json", "cannot be written"});
}

TEST(Dataset, ReadsACapture) {
  const TempFolder folder;
  write_transforms(folder.path() / "transforms.json", make_dataset(folder));
  const Dataset dataset = load_dataset(folder.path());
  const Capture capture = read_capture(dataset, 1);
  EXPECT_EQ(capture.sequence, 2u);
  EXPECT_EQ(capture.name, "images/1.png");
  EXPECT_EQ(capture.image.width, 13);
  EXPECT_EQ(capture.image.format, PixelFormat::kRGB8);
  EXPECT_EQ(capture.image.bytes[0], 50);
  EXPECT_EQ(capture.mask.width(), 13);
  EXPECT_EQ(capture.mask.channels(), 1);
  EXPECT_EQ(capture.pose.status, PoseStatus::kGiven);
  EXPECT_EQ(capture.purpose, Purpose::kTraining);
  EXPECT_EQ(capture.exposure.exposure_s, 0) << "unknown";
  EXPECT_EQ(read_capture(dataset, 0).source_session, capture.source_session);
  EXPECT_NE(read_capture(dataset, 0).calibration_hash, capture.calibration_hash) << "another camera";
  EXPECT_EQ(load_dataset(folder.path()).hash, dataset.hash);
  folder.write("transforms.json", read_file(folder.path() / "transforms.json") + " ");
  EXPECT_NE(load_dataset(folder.path()).hash, dataset.hash);
}

/// The hash before and after each change must differ, and come back when the change is undone.
class DatasetIdentity : public testing::Test {
 protected:
  DatasetIdentity() {
    make_dataset(folder);
    folder.write("cameras.txt", "1 PINHOLE 12 8 20 20 6 4\n2 PINHOLE 13 8 20 20 6.5 4\n");
    folder.write("images.txt", "1 1 0 0 0 1 2 3 1 0.png\n\n2 1 0 0 0 1 2 3 2 1.png\n\n");
    fs::rename(folder.path() / "masks/0.png", folder.path() / "masks/0.png.png");
  }
  std::string hash() const { return load_dataset(folder.path()).hash; }
  void expect_covers(const char* file, const std::string& changed) {
    const std::string before = hash(), bytes = read_file(folder.path() / file);
    const auto written = fs::last_write_time(folder.path() / file);
    folder.write(file, changed);
    fs::last_write_time(folder.path() / file, written);
    EXPECT_NE(hash(), before) << file;
    folder.write(file, bytes);
    fs::last_write_time(folder.path() / file, written + std::chrono::hours(1));
    EXPECT_EQ(hash(), before) << file << ": the same content of another date is the same data set";
  }
  /// The file with one bit turned, of the same size.
  std::string touched(const char* file) const {
    std::string bytes = read_file(folder.path() / file);
    bytes[bytes.size() / 2] ^= 1;
    return bytes;
  }

  const TempFolder folder;
};

TEST_F(DatasetIdentity, CoversAllThatAColmapModelDelivers) {
  expect_covers("images/1.png", touched("images/1.png"));
  expect_covers("masks/0.png.png", touched("masks/0.png.png"));
  expect_covers("cameras.txt", "1 PINHOLE 12 8 20 20 6 4\n2 PINHOLE 13 8 20 21 6.5 4\n");
  expect_covers("images.txt", "1 1 0 0 0 1 2 4 1 0.png\n\n2 1 0 0 0 1 2 3 2 1.png\n\n");
  expect_covers("images.txt", "2 1 0 0 0 1 2 3 2 1.png\n\n1 1 0 0 0 1 2 3 1 0.png\n\n");
  const std::string before = hash();
  fs::remove(folder.path() / "masks/0.png.png");
  EXPECT_NE(hash(), before) << "without its mask";
}

TEST_F(DatasetIdentity, CoversAllThatATransformsFileDelivers) {
  fs::rename(folder.path() / "masks/0.png.png", folder.path() / "masks/0.png");
  auto views = make_dataset(folder);
  const fs::path file = folder.path() / "transforms.json";
  write_transforms(file, views);
  expect_covers("images/2.png", touched("images/2.png"));
  expect_covers("masks/2.png", touched("masks/2.png"));
  const std::string before = hash(), text = read_file(file);
  std::swap(views[0], views[1]);
  write_transforms(file, views);
  EXPECT_NE(hash(), before) << "another order";
  folder.write("transforms.json", text);
  EXPECT_EQ(hash(), before);
  const TempFolder copy;
  fs::copy(folder.path(), copy.path(), fs::copy_options::recursive);
  EXPECT_EQ(load_dataset(copy.path()).hash, before) << "the same elsewhere";
}

TEST(Dataset, SizesThatDoNotMatchNameBoth) {
  const TempFolder folder;
  write_transforms(folder.path() / "transforms.json", make_dataset(folder));
  const Dataset dataset = load_dataset(folder.path());
  check_sizes(dataset);
  write_png(folder.path() / "images/0.png", ImageU8(7, 8, 3));
  expect_error([&] { read_capture(dataset, 0); }, {"images/0.png", "7 x 8", "12 x 8"});
  expect_error([&] { check_sizes(load_dataset(folder.path())); }, {"images/0.png", "7 x 8", "12 x 8"});
  write_png(folder.path() / "masks/1.png", ImageU8(13, 9, 1));
  expect_error([&] { read_capture(dataset, 1); }, {"masks/1.png", "13 x 9", "13 x 8"});
}

TEST(Dataset, AnImageThatExifWantsTurnedIsToldAndTakenAsItIsStored) {
  const TempFolder folder;
  auto views = make_dataset(folder);
  write_transforms(folder.path() / "transforms.json", views);
  EXPECT_EQ(load_dataset(folder.path()).warning, "");
  // An eXIf chunk with one entry, orientation 6, behind the 33 bytes of signature and header.
  const auto turn = [&](const char* file) {
    const std::string png = read_file(folder.path() / file);
    const std::string tiff("II*\0\10\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0", 26);
    const std::string chunk = std::string("\0\0\0\x1a", 4) + "eXIf" + tiff + std::string("\xb7\x48\x11\x29", 4);
    folder.write(file, png.substr(0, 33) + chunk + png.substr(33));
  };
  turn("images/1.png");
  const Dataset dataset = load_dataset(folder.path());
  EXPECT_NE(dataset.warning.find("images/1.png: EXIF says"), std::string::npos) << dataset.warning;
  turn("images/2.png");
  EXPECT_NE(load_dataset(folder.path()).warning.find("images/1.png and 1 others"), std::string::npos);
  EXPECT_EQ(read_capture(dataset, 1).image.width, 13);
  std::swap(views[1].camera.width, views[1].camera.height);
  write_transforms(folder.path() / "transforms.json", views);
  expect_error([&] { read_capture(load_dataset(folder.path()), 1); }, {"images/1.png", "13 x 8", "8 x 13", "exiftran"});
}

TEST(Dataset, ImageNamedWithoutItsExtension) {
  const TempFolder folder;
  fs::create_directories(folder.path() / "train");
  write_exr(folder.path() / "train/r_0.exr", ImageF(4, 3, 3, 0.5f));
  write_png(folder.path() / "train/r_1.png", ImageU8(6, 2, 3));
  folder.write("transforms.json", R"({"camera_angle_x": 0.7, "frames": [
    {"file_path": "./train/r_0", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "./train/r_1", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const Dataset dataset = load_dataset(folder.path());
  EXPECT_EQ(dataset.views[0].camera.width, 4);
  EXPECT_EQ(dataset.views[1].camera.height, 2);
  EXPECT_EQ(read_capture(dataset, 0).image.format, PixelFormat::kRGB32f);
}

TEST(Dataset, CamerasAloneNeedNoImages) {
  const TempFolder folder;
  const auto views = make_dataset(folder);
  write_transforms(folder.path() / "transforms.json", views);
  fs::remove_all(folder.path() / "images");
  const auto cameras = load_cameras(folder.path() / "transforms.json");
  ASSERT_EQ(cameras.size(), 3u);
  EXPECT_EQ(cameras[2].camera.width, 14);
  EXPECT_EQ(cameras[2].purpose, Purpose::kHeldOut);
  expect_error([&] { load_dataset(folder.path()); }, {"only 0 of its 3 images", "images/0.png", "no such image"});
  auto some = nlohmann::json::parse(read_file(folder.path() / "transforms.json"));
  some["frames"].erase(2);  // which test_filenames and val_filenames name
  const auto path = folder.write("some.json", some.dump());
  EXPECT_EQ(load_cameras(path).size(), 2u);
  make_dataset(folder);
  expect_error([&] { load_dataset(path); }, {"some.json", "val_filenames", "images/2.png"});
  const auto blender = folder.write("b.json", R"({"camera_angle_x": 0.7, "frames": [
    {"file_path": "r_0", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  expect_error([&] { load_cameras(blender); }, {"b.json", "r_0", "w and h are missing"});
}

TEST(Dataset, ColmapFoldersWithMasks) {
  for (const char* place : {"", "sparse/", "sparse/0/"}) {
    const TempFolder folder;
    make_dataset(folder);
    folder.write(std::string(place) + "cameras.txt", "1 PINHOLE 12 8 20 20 6 4\n2 PINHOLE 13 8 20 20 6.5 4\n");
    folder.write(std::string(place) + "images.txt", "1 1 0 0 0 1 2 3 1 0.png\n\n2 0 1 0 0 1 2 3 2 1.png\n1 2 -1\n");
    fs::rename(folder.path() / "masks/0.png", folder.path() / "masks/0.png.png");
    fs::remove(folder.path() / "masks/1.png");
    const Dataset dataset = load_dataset(folder.path());
    ASSERT_EQ(dataset.views.size(), 2u);
    EXPECT_EQ(dataset.views[0].purpose, Purpose::kUnspecified);
    EXPECT_TRUE(dataset.views[0].mask_path);
    EXPECT_FALSE(dataset.views[1].mask_path);
    EXPECT_EQ(read_capture(dataset, 0).mask.width(), 12);
    EXPECT_EQ(read_capture(dataset, 1).image.width, 13);
    // Half a turn round x: the world's y and z are the camera's -y and -z.
    EXPECT_NEAR((dataset.views[1].camera_from_object * Eigen::Vector3d(0, 1, 1) - Eigen::Vector3d(1, 1, 2)).norm(), 0,
                1e-12);
  }
}

TEST(Dataset, ColmapModelsThatContradictThemselves) {
  const TempFolder folder;
  make_dataset(folder);
  folder.write("cameras.txt", "1 PINHOLE 12 8 20 20 6 4\n");
  const auto refused = [&](const char* images, const std::vector<std::string>& words) {
    folder.write("images.txt", images);
    expect_error([&] { load_dataset(folder.path()); }, words);
  };
  refused("1 1 0 0 0 1 2 3 5 0.png\n", {"images.txt", "image 0.png", "camera 5"});
  refused("1 1 0 0 0 1 2 3 1 9.png\n", {"only 0 of its 1 images", "9.png", "no such image"});
  refused("1 2 0 0 0 1 2 3 1 0.png\n", {"images.txt", "image 0.png", "unit quaternion"});
  refused("1 1 0 0 0 1 2 3 1 0.png\n\n2 1 0 0 0 1 2 3 1 0.png\n", {"image 0.png", "twice"});
  refused("# nothing\n", {"images.txt", "no image"});
  // The binary twin is preferred, so a broken one is not passed over.
  folder.write("images.txt", "1 1 0 0 0 1 2 3 1 0.png\n");
  EXPECT_EQ(load_dataset(folder.path()).views.size(), 1u);
  folder.write("cameras.bin", "");
  folder.write("images.bin", "");
  expect_error([&] { load_dataset(folder.path()); }, {"cameras.bin", "cut off"});
}

TEST(Dataset, NothingThere) {
  const TempFolder folder;
  expect_error([&] { load_dataset(folder.path()); }, {"transforms.json", "COLMAP"});
  expect_error([&] { load_dataset(folder.path() / "none"); }, {"none", "no such folder"});
}

class SharedDataset : public testing::TestWithParam<const char*> {};

// Two descriptions of the same cameras, made independently: transforms.json in OpenGL axes and cameras.json in
// OpenCV's.
TEST_P(SharedDataset, AgreesWithItsCamerasInOpenCvConvention) {
  const fs::path folder = shared_data(GetParam());
  if (!fs::exists(folder)) GTEST_SKIP() << "no shared data";
  const Dataset dataset = load_dataset(folder);
  const auto truth = nlohmann::json::parse(read_file(folder / "cameras.json")).at("views");
  ASSERT_EQ(dataset.views.size(), truth.size());
  std::size_t held_out = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const DatasetView& view = dataset.views[i];
    EXPECT_EQ(view.name, truth[i].at("file"));
    EXPECT_EQ(view.camera.width, truth[i].at("width"));
    EXPECT_EQ(view.camera.height, truth[i].at("height"));
    const auto& k = truth[i].at("K");
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    for (int r = 0; r < 3; ++r) {
      translation[r] = truth[i].at("t")[r];
      for (int c = 0; c < 3; ++c) rotation(r, c) = truth[i].at("R")[r][c];
    }
    EXPECT_NEAR(view.camera.fx, k[0][0].get<double>(), 1e-4);
    EXPECT_NEAR(view.camera.fy, k[1][1].get<double>(), 1e-4);
    EXPECT_NEAR(view.camera.cx, k[0][2].get<double>(), 1e-4);
    EXPECT_NEAR(view.camera.cy, k[1][2].get<double>(), 1e-4);
    EXPECT_NEAR((view.camera_from_object.rotation.toRotationMatrix() - rotation).norm(), 0, 1e-6);
    EXPECT_NEAR((view.camera_from_object.translation - translation).norm(), 0, 1e-5 * (1 + translation.norm()));
    held_out += view.purpose == Purpose::kHeldOut;
  }
  EXPECT_GT(held_out, 0u);
  EXPECT_LT(held_out, truth.size() / 4);
  const Capture capture = read_capture(dataset, 0);
  EXPECT_EQ(validation_error(capture.image), "");
}

INSTANTIATE_TEST_SUITE_P(, SharedDataset,
                         testing::Values("buddha_alicevision", "cube_desk", "temple_middlebury", "juice_iory"));

// The same set's own COLMAP files against its transforms.json: poses agree, while the cameras, which describe other
// images, do not, and reading says so.
TEST(SharedColmap, PosesAgreeWithTheTransformsOfTheSameSet) {
  const fs::path source = shared_data("cube_desk");
  if (!fs::exists(source)) GTEST_SKIP() << "no shared data";
  const TempFolder folder;
  fs::copy_file(source / "colmap_cameras.txt", folder.path() / "cameras.txt");
  fs::copy_file(source / "colmap_images.txt", folder.path() / "images.txt");
  fs::create_directory_symlink(fs::absolute(source / "images"), folder.path() / "images");
  const Dataset colmap = load_dataset(folder.path()), transforms = load_dataset(source);
  ASSERT_EQ(colmap.views.size(), transforms.views.size());
  for (const DatasetView& view : colmap.views) {
    const auto same = std::find_if(transforms.views.begin(), transforms.views.end(),
                                   [&](const DatasetView& v) { return v.name == "images/" + view.name; });
    ASSERT_NE(same, transforms.views.end());
    EXPECT_NEAR((view.camera_from_object.matrix() - same->camera_from_object.matrix()).norm(), 0, 1e-5);
  }
  expect_error([&] { read_capture(colmap, 0); }, {"1000 x 748", "1280 x 960"});
}

}  // namespace
}  // namespace sheen
