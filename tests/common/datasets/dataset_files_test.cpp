// SPDX-License-Identifier: Apache-2.0
// Which files a data set is made of: how they are found by their names, and what is told of those that are not used.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/datasets/applied_transform.h"
#include "common/datasets/dataset.h"
#include "common/datasets/file_finder.h"
#include "common/datasets/stored_images.h"
#include "common/image/image_io.h"
#include "support/expect_error.h"
#include "support/icc_profile.h"
#include "support/raw_png.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char *kComposed = "S\xc3\xa4ule.png", *kDecomposed = "Sa\xcc\x88ule.png";

TEST(FileNames, AreEqualOnWhicheverSystemTheyWereWritten) {
  EXPECT_EQ(loose_name(kComposed), loose_name(kDecomposed));
  EXPECT_EQ(loose_name("IMG_1.JPG"), loose_name("img_1.jpg"));
  EXPECT_NE(loose_name("a.png"), loose_name("b.png"));
  EXPECT_EQ(loose_name("\xe4.png"), "\xe4.png") << "no UTF-8";
  EXPECT_EQ(normal_name(".\\images\\a.png"), "images/a.png");
}

TEST(FileFinding, ByNamesOfOtherSystems) {
  const TempFolder folder;
  const fs::path root = folder.path() / "fox";
  const auto file = [&](const std::string& name) { return folder.write("fox/" + name, "x"); };
  const fs::path plain = file("images/0001.png"), accent = file("images/" + std::string(kDecomposed)),
                 upper = file("images/0002.JPG");
  const FileFinder finder(root);
  for (const char* name : {"images/0001.png", "images\\0001.png", ".\\images\\0001.png", "Images/0001.PNG",
                           "C:\\Users\\x\\fox\\images\\0001.png", "/home/y/images/0001.png", "data/../images/0001.png",
                           "fox/images/0001.png"})
    EXPECT_EQ(finder.find(name).lexically_normal(), plain) << name;
  EXPECT_EQ(finder.find("images/" + std::string(kComposed)), accent);
  EXPECT_EQ(finder.find_image("images/S\xc3\xa4ule"), accent);
  EXPECT_EQ(finder.find_image("images/0002"), upper);
  EXPECT_EQ(finder.find("images/0002.jpg"), upper);
  for (const char* name : {"images/0003.png", "other/0001.png", "../images/0001.png", "images", ""})
    EXPECT_EQ(finder.find(name), fs::path()) << name;
  const fs::path both = file("A.png");
  file("a.PNG");
  EXPECT_EQ(finder.find("A.png"), both) << "as it is written";
  EXPECT_EQ(FileFinder(root).find("a.png"), fs::path()) << "either may be meant";
}

/// Images of one colour each and a description of them.
class DatasetFiles : public ::testing::Test {
 protected:
  void image(const std::string& name, int channels = 3) const {
    ImageU8 pixels(12, 8, channels, 40);
    if (channels == 3) pixels.at(2, 2, 1) = 200;
    fs::create_directories((root() / name).parent_path());
    write_png(root() / name, pixels);
  }
  void mask(const std::string& name) const { image(name, 1); }
  static Json frame(const std::string& name, double x = 1) {
    return {{"file_path", name}, {"transform_matrix", {{0, 0, 1, x}, {1, 0, 0, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}}}};
  }
  void transforms(const std::vector<std::string>& names, const std::string& file = "transforms.json") const {
    Json frames = Json::array();
    for (const std::string& name : names) frames.push_back(frame(name));
    write(file, Json{{"w", 12}, {"h", 8}, {"fl_x", 20}, {"frames", frames}}.dump());
  }
  void colmap(const std::string& place, const std::vector<std::string>& names) const {
    write(place + "/cameras.txt", "1 PINHOLE 12 8 20 20 6 4\n");
    std::string images;
    for (const std::string& name : names) images += "1 1 0 0 0 1 2 3 1 " + name + "\n\n";
    write(place + "/images.txt", images);
  }
  void write(const std::string& name, const std::string& bytes) const { folder_.write(name, bytes); }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const DatasetView& view : load_dataset(root()).views) names.push_back(view.name);
    return names;
  }
  ImageAccount account() const { return load_dataset(root()).account; }
  std::string told() const { return in_words(account(), root()); }
  const fs::path& root() const { return folder_.path(); }

  const TempFolder folder_;
};

TEST_F(DatasetFiles, NamesOfAWindowsMachineAndListsOfThem) {
  image("images/a.png");
  image("images/b.png");
  Json json{{"w", 12}, {"h", 8}, {"fl_x", 20}, {"test_filenames", {"images\\b.png"}}};
  json["frames"] = {frame("images\\a.png"), frame("images\\b.png")};
  write("transforms.json", json.dump());
  const Dataset dataset = load_dataset(root());
  EXPECT_EQ(dataset.views[0].name, "images/a.png");
  EXPECT_EQ(dataset.views[1].purpose, Purpose::kHeldOut);
  EXPECT_THAT(told(), testing::EndsWith("2 of 2 images, 0 masks"));
}

TEST_F(DatasetFiles, WhatLiesUnusedIsNamed) {
  for (const char* name : {"images/a.png", "images/b.png", "images/c.png", "images/a_depth.png"}) image(name);
  for (int i = 0; i < 12; ++i) mask("masks/" + std::to_string(i) + ".png");
  image(".thumbnails/a.png");
  transforms({"images/a.png", "images/b.png"});
  EXPECT_THAT(told(), HasSubstr("2 of 3 images, 0 masks\nnot used: 14 image files in this folder: "));
  EXPECT_THAT(told(), HasSubstr("images/a_depth.png, images/c.png, masks (12 files, such as 0.png)"));
  EXPECT_THAT(told(), Not(HasSubstr("thumbnails")));
}

TEST_F(DatasetFiles, WhatIsMissingOrDamagedIsLeftOutAndTold) {
  for (const char* name : {"a.png", "b.png", "c.png"}) image(name);
  transforms({"a.png", "b.png", "c.png", "d.png"});
  fs::resize_file(root() / "c.png", fs::file_size(root() / "c.png") - 20);
  const Dataset dataset = load_dataset(root());
  ASSERT_EQ(dataset.views.size(), 2u);
  EXPECT_EQ(dataset.account.of, 4u);
  EXPECT_THAT(dataset.account.unused, IsEmpty());
  const std::string words = in_words(dataset.account, root());
  EXPECT_THAT(words, HasSubstr("2 of 4 images"));
  EXPECT_THAT(words, HasSubstr("left out: d.png: there is no such image"));
  EXPECT_THAT(words, HasSubstr("left out: c.png: "));
  EXPECT_THAT(words, HasSubstr("damaged PNG"));
  EXPECT_EQ(read_capture(dataset, 1).name, "b.png");
  write("b.png", "");
  expect_error([&] { load_dataset(root()); }, {"only 1 of its 4 images", "d.png", "no such image"});
}

TEST_F(DatasetFiles, AnImageOfAnotherSizeIsToldBeforeTheWork) {
  for (const char* name : {"a.png", "b.png"}) image(name);
  transforms({"a.png", "b.png"});
  write_png(root() / "b.png", ImageU8(8, 12, 3));
  expect_error([&] { open_stored_images(root()); }, {"b.png", "8 x 12", "12 x 8"});
}

TEST_F(DatasetFiles, GreyImagesAmongColouredOnesAreNamed) {
  image("a.png");
  image("b.png", 1);
  ImageU8 grey(12, 8, 3, 90);
  grey.at(0, 0, 2) = 92;  // as lossy coding leaves it
  write_png(root() / "c.png", grey);
  transforms({"a.png", "b.png", "c.png"});
  EXPECT_THAT(told(), HasSubstr("2 of 3 images are grey: b.png, c.png"));
  transforms({"b.png", "c.png"});
  EXPECT_THAT(told(), Not(HasSubstr("grey"))) << "all of them";
}

TEST_F(DatasetFiles, ColoursOfAnotherSpaceAreTold) {
  for (const char* name : {"a.png", "b.png"}) image(name);
  const auto plain = encode_jpeg(ImageU8(12, 8, 3, 90), 90);
  std::string jpeg(plain.begin(), plain.end());
  write("c.jpg", jpeg);
  transforms({"a.png", "b.png", "c.jpg"});
  EXPECT_THAT(told(), Not(HasSubstr("colour space")));
  jpeg.insert(2, jpeg_profile(icc_profile("Display P3", kDisplayP3, parametric_srgb())));
  write("c.jpg", jpeg);
  EXPECT_THAT(told(), HasSubstr("1 image is of another colour space (Display P3): c.jpg"));
  write("list.lp", "1\nc.jpg 0 0 1\n");
  EXPECT_THAT(open_stored_images(root() / "list.lp").summary, HasSubstr("(Display P3): c.jpg"));
}

TEST_F(DatasetFiles, TextBesideABinaryModelIsComparedWithIt) {
  for (const char* name : {"a.png", "b.png"}) image(name);
  const auto put = [](std::string& bytes, auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  std::string cameras, images;
  put(cameras, std::uint64_t(1));
  put(cameras, std::uint32_t(1));
  put(cameras, std::int32_t(1));  // PINHOLE
  for (const std::uint64_t size : {12, 8}) put(cameras, size);
  for (const double value : {20., 20., 6., 4.}) put(cameras, value);
  put(images, std::uint64_t(2));
  for (const char* name : {"a.png", "b.png"}) {
    put(images, std::uint32_t(1));
    for (const double value : {1., 0., 0., 0., 1., 2., 3.}) put(images, value);
    put(images, std::uint32_t(1));
    images += name + std::string(1, '\0');
    put(images, std::uint64_t(0));
  }
  write("sparse/0/cameras.bin", cameras);
  write("sparse/0/images.bin", images);
  colmap("sparse/0", {"a.png", "b.png"});
  EXPECT_EQ(load_dataset(root()).warning, "") << "both say the same";
  colmap("sparse/0", {"a.png"});
  EXPECT_THAT(load_dataset(root()).warning, HasSubstr("images.bin is read, and not images.txt beside it"));
  write("sparse/0/images.txt", "1 1 0 0 0 1 2 3 1 a.png\n\n2 1 0 0 0 1 2 3.1 1 b.png\n\n");
  EXPECT_THAT(load_dataset(root()).warning, HasSubstr("which has other images or poses"));
  write("sparse/0/images.txt", "no model");
  EXPECT_THAT(load_dataset(root()).warning, HasSubstr("which cannot be read"));
}

TEST_F(DatasetFiles, SomeMasksAndAlphas) {
  for (const char* name : {"a.png", "b.png", "c.png"}) image(name);
  mask("m.png");
  Json json{{"w", 12}, {"h", 8}, {"fl_x", 20}};
  json["frames"] = {frame("a.png"), frame("b.png"), frame("c.png")};
  json["frames"][1]["mask_path"] = "m.png";
  write("transforms.json", json.dump());
  EXPECT_THAT(told(), HasSubstr("3 of 3 images, 1 of 3 masks"));
  json["frames"][0]["mask_path"] = "none.png";
  write("transforms.json", json.dump());
  EXPECT_THAT(told(), HasSubstr("2 of 3 images, 1 of 2 masks\nleft out: a.png: there is no such mask: \"none.png\""));
  json["frames"][0].erase("mask_path");
  write("transforms.json", json.dump());
  ImageU8 cutout(12, 8, 4, 255);
  cutout.at(3, 4, 3) = 0;
  for (const char* name : {"b.png", "c.png"}) write_png(root() / name, cutout);
  EXPECT_THAT(told(), HasSubstr("2 of 3 masks (alpha of the images)\nthe alpha of 1 image is not used"));
  const Dataset dataset = load_dataset(root());
  EXPECT_TRUE(read_capture(dataset, 0).mask.empty());
  EXPECT_EQ(read_capture(dataset, 1).mask.at(3, 4), 255) << "the file's";
  EXPECT_EQ(read_capture(dataset, 2).mask.at(3, 4), 0) << "the alpha's";
  write_transforms(root() / "again.json", dataset.views);
  EXPECT_EQ(load_dataset(root() / "again.json").account.masks, 2u) << "masks of some are written, too";
}

TEST_F(DatasetFiles, TrainAndTestInFilesOfTheirOwn) {
  for (const char* name : {"train/r_0.png", "train/r_1.png", "test/r_0.png", "test/r_0_depth_0001.png", "val/r_0.png"})
    image(name);
  transforms({"./train/r_0", "./train/r_1"}, "transforms_train.json");
  transforms({"./val/r_0"}, "transforms_val.json");
  EXPECT_EQ(load_dataset(root()).views[2].purpose, Purpose::kHeldOut) << "without test views those of val";
  transforms({"./test/r_0"}, "transforms_test.json");
  const Dataset dataset = load_dataset(root());
  EXPECT_THAT(names(), ElementsAre("./train/r_0", "./train/r_1", "./test/r_0"));
  EXPECT_EQ(dataset.views[1].purpose, Purpose::kTraining);
  EXPECT_EQ(dataset.views[2].purpose, Purpose::kHeldOut);
  EXPECT_THAT(dataset.warning, HasSubstr("transforms_test.json are held out; transforms_val.json is not read"));
  EXPECT_THAT(told(), HasSubstr("3 of 3 images"));
  EXPECT_THAT(told(), HasSubstr("2 image files in this folder: test/r_0_depth_0001.png, val/r_0.png"));
  transforms({"train/r_1"}, "transforms_test.json");
  expect_error([&] { load_dataset(root()); }, {"./train/r_1", "are one image"});
}

TEST_F(DatasetFiles, OfColmapModelsTheLargestIsRead) {
  for (const char* name : {"images/a.png", "images/b.png", "images/c.png"}) image(name);
  colmap("sparse/0", {"a.png"});
  EXPECT_EQ(load_dataset(root()).warning, "");
  EXPECT_THAT(told(), HasSubstr("1 of 3 images"));
  colmap("sparse/2", {"a.png", "b.png"});
  colmap("sparse/10", {"b.png", "c.png"});
  EXPECT_THAT(names(), ElementsAre("a.png", "b.png")) << "of two as large the first";
  const std::string warning = load_dataset(root()).warning;
  EXPECT_THAT(warning, HasSubstr("3 COLMAP models"));
  EXPECT_THAT(warning, HasSubstr("sparse/2 (2 images); not read: "));
  EXPECT_THAT(warning, HasSubstr("sparse/0 (1 images), "));
  EXPECT_THAT(told(), HasSubstr("2 of 3 images, 0 masks\nnot used: 1 image file in this folder: images/c.png"));
  colmap("sparse", {"a.png", "b.png", "c.png"});
  EXPECT_EQ(names().size(), 3u);
}

TEST_F(DatasetFiles, WhatAColmapModelHoldsOut) {
  for (const char* name : {"images/a.png", "images/b.png", "images/c.png"}) image(name);
  colmap("sparse/0", {"a.png", "b.png", "c.png"});
  const std::string hash = load_dataset(root()).hash;
  EXPECT_EQ(load_dataset(root()).views[0].purpose, Purpose::kUnspecified);
  write("sparse/0/test.txt", "b.png\r\n\n");
  const Dataset dataset = load_dataset(root());
  EXPECT_EQ(dataset.views[0].purpose, Purpose::kTraining);
  EXPECT_EQ(dataset.views[1].purpose, Purpose::kHeldOut);
  EXPECT_THAT(dataset.warning, HasSubstr("test.txt: its 1 images are held out"));
  EXPECT_NE(dataset.hash, hash) << "it is another data set";
  write("sparse/0/test.txt", "");
  EXPECT_EQ(load_dataset(root()).views[1].purpose, Purpose::kTraining) << "none is held out";
  write("sparse/0/test.txt", "d.png\n");
  expect_error([&] { load_dataset(root()); }, {"sparse/0/test.txt", "d.png"});
}

TEST_F(DatasetFiles, MasksOfColmapByTheNamesThatToolsGive) {
  for (const char* name : {"images/a.jpg", "images/b.jpg", "images/sub/c.jpg", "images/d.jpg", "images/e.jpg"})
    image(name);
  colmap("sparse/0", {"a.jpg", "b.jpg", "sub\\c.jpg", "d.jpg", "e.jpg"});
  for (const char* name : {"masks/a.jpg.png", "masks/b.jpg", "masks/sub/c.PNG", "masks/d_mask.png", "masks/x.png"})
    mask(name);
  const Dataset dataset = load_dataset(root());
  const auto mask_of = [&](std::size_t i) {
    const auto& path = dataset.views.at(i).mask_path;
    return path ? path->lexically_relative(root()).generic_string() : "";
  };
  EXPECT_EQ(mask_of(0), "masks/a.jpg.png");
  EXPECT_EQ(mask_of(1), "masks/b.jpg");
  EXPECT_EQ(mask_of(2), "masks/sub/c.PNG");
  EXPECT_EQ(mask_of(3), "masks/d_mask.png");
  EXPECT_EQ(mask_of(4), "");
  EXPECT_THAT(told(), HasSubstr("5 of 5 images, 4 of 5 masks\nnot used: 1 image file in this folder: masks/x.png"));
}

TEST_F(DatasetFiles, MasksOfColmapWithWordsInTheirNames) {
  for (const char* name : {"images/a.jpg", "images/sub/b.jpg", "images/c.jpg", "images/sub/d.jpg"}) image(name);
  colmap("sparse/0", {"a.jpg", "sub/b.jpg", "c.jpg", "sub/d.jpg"});
  for (const char* name : {"masks/a-mask.png", "masks/sub/mask_b.png", "mask/c.mask.PNG", "images/sub/d_mask.png"})
    mask(name);
  EXPECT_THAT(told(), testing::EndsWith("4 of 4 images, 4 masks"));
}

TEST_F(DatasetFiles, SayWhatWasAppliedToTheirPoses) {
  const auto says = [&](const Json& json) {
    write("transforms.json", json.dump());
    return applied_to_poses(root());
  };
  const Json turn = {{0, 1, 0, 1}, {1, 0, 0, 2}, {0, 0, -1, 3}};
  const auto applied = says({{"applied_transform", turn}, {"applied_scale", 0.5}});
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied_to_poses(root() / "transforms.json"), applied);
  const Eigen::Vector4d point = *applied * Eigen::Vector4d(10, 20, 30, 1);
  EXPECT_LT((point - Eigen::Vector4d(10.5, 6, -13.5, 1)).norm(), 1e-12);
  EXPECT_FALSE(says({{"frames", 1}}));
  EXPECT_FALSE(says({{"applied_transform", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}}}})) << "a reflection";
  EXPECT_FALSE(says({{"applied_transform", "none"}}));
  EXPECT_FALSE(applied_to_poses(root() / "none"));
}

TEST_F(DatasetFiles, NamesAreToldWithoutWhatATerminalObeys) {
  image("images/a.png");
  image("images/b\n\x1b[31m.png");
  transforms({"images/a.png"});
  EXPECT_THAT(told(), HasSubstr("not used: 1 image file in this folder: images/b??[31m.png"));
}

}  // namespace
}  // namespace sheen
