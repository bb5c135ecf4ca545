// SPDX-License-Identifier: Apache-2.0
// A USDZ as its specification has it, read byte by byte. No device of Apple's was tried.
#include "reconstructor/exchange/usdz_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "common/base/files.h"
#include "common/image/jpeg.h"
#include "reconstructor/exchange/mesh_files.h"
#include "tests/support/expect_error.h"
#include "tests/support/process.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

TexturedMesh square(int side) {
  TexturedMesh mesh;
  mesh.mesh.vertices = {{0, 0, 0.5f}, {1, 0, 0.5f}, {1, 2, 0.5f}, {0, 2, 0.5f}};
  mesh.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.normals.assign(4, Eigen::Vector3f::UnitZ());
  mesh.place = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  mesh.picture = ImageU8(side, side, 3, 200);
  return mesh;
}

template <typename T>
std::uint64_t number(const std::string& bytes, std::size_t at) {
  T value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// Bytes of the files by their names, through the directory at the end; checks what USDZ asks for.
std::map<std::string, std::string> contents(const std::string& zip, std::vector<std::string>& order) {
  std::map<std::string, std::string> files;
  const std::size_t end = zip.size() - 22;
  EXPECT_EQ(number<std::uint32_t>(zip, end), 0x06054b50u);
  std::size_t entry = number<std::uint32_t>(zip, end + 16);
  EXPECT_EQ(entry + number<std::uint32_t>(zip, end + 12), end) << "the directory's size";
  for (std::uint64_t i = 0; i < number<std::uint16_t>(zip, end + 10); ++i) {
    EXPECT_EQ(number<std::uint32_t>(zip, entry), 0x02014b50u);
    EXPECT_EQ(number<std::uint16_t>(zip, entry + 10), 0u) << "stored";
    const std::size_t bytes = number<std::uint32_t>(zip, entry + 24), name = number<std::uint16_t>(zip, entry + 28),
                      local = number<std::uint32_t>(zip, entry + 42);
    EXPECT_EQ(number<std::uint32_t>(zip, entry + 20), bytes);
    order.push_back(zip.substr(entry + 46, name));
    EXPECT_EQ(number<std::uint32_t>(zip, local), 0x04034b50u);
    EXPECT_EQ(zip.substr(local + 30, name), order.back());
    EXPECT_EQ(zip.substr(local + 14, 12), zip.substr(entry + 16, 12)) << "checksum and sizes in both headers";
    const std::size_t data = local + 30 + name + number<std::uint16_t>(zip, local + 28);
    EXPECT_EQ(data % 64, 0u) << order.back();
    files[order.back()] = zip.substr(data, bytes);
    entry += 46 + name + number<std::uint16_t>(zip, entry + 30) + number<std::uint16_t>(zip, entry + 32);
  }
  return files;
}

TEST(UsdzFile, IsWhatTheFormatSays) {
  const TempFolder temp;
  const auto file = temp.path() / "square.usdz";
  write_usdz(file, square(64), upright(Eigen::Vector3d::UnitZ()));
  std::vector<std::string> order;
  const auto files = contents(read_file(file), order);
  EXPECT_THAT(order, ::testing::ElementsAre("scene.usda", "picture.jpg")) << "the scene is the first";
  const std::string& scene = files.at("scene.usda");
  EXPECT_TRUE(scene.starts_with("#usda 1.0\n"));
  for (const char* word :
       {"metersPerUnit = 1\n", "upAxis = \"Y\"", "defaultPrim = \"Object\"", "subdivisionScheme = \"none\"",
        "faceVertexCounts = [3, 3]", "faceVertexIndices = [0, 1, 2, 0, 2, 3]", "UsdPreviewSurface", "@picture.jpg@",
        "points = [(0, 0.5, 0), (1, 0.5, 0), (1, 0.5, -2), (0, 0.5, -2)]", "extent = [(0, 0.5, -2), (1, 0.5, 0)]",
        "normals = [(0, 1, 0),", "st = [(0, 0), (1, 0), (1, 1), (0, 1)]"})
    EXPECT_THAT(scene, HasSubstr(word));
  const ImageU8 picture = decode_jpeg(files.at("picture.jpg"));
  EXPECT_EQ(picture.width(), 64);
  EXPECT_NEAR(picture.at(30, 30, 1), 200, 2);
}

TEST(UsdzFile, ZipsOfOthersOpenIt) {
  const TempFolder temp;
  const auto file = temp.path() / "square.usdz";
  write_usdz(file, square(64), Eigen::Matrix3f::Identity());
  testing::Process python({"/usr/bin/python3", "-m", "zipfile", "-t", file});
  const auto end = python.wait(std::chrono::seconds(60));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->status, 0) << python.output();
  EXPECT_THAT(python.output(), ::testing::Not(HasSubstr("bad"))) << "checksums";
}

TEST(UsdzFile, APictureForATelephone) {
  const TempFolder temp;
  expect_error([&] { write_usdz(temp.path() / "a.usdz", square(2049), Eigen::Matrix3f::Identity()); },
               {"a.usdz", "2048 texels"});
}

}  // namespace
}  // namespace sheen
