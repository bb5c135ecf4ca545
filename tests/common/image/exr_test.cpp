// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/base/files.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

ImageF noise(int width, int height, int channels, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> value(0, 100);
  ImageF image(width, height, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = value(random);
  return image;
}

TEST(Exr, FloatPartsOfSeveralSizesComeBackBitForBit) {
  const TempFolder folder;
  ExrFile file;
  file.parts.push_back({"beauty", {"R", "G", "B"}, noise(17, 9, 3, 1)});
  file.parts.push_back({"depth", {"Z"}, noise(40, 33, 1, 2)});
  file.parts.push_back({"surface.rank00", {"basis.R", "basis.G", "basis.B"}, noise(5, 1, 3, 3)});
  file.parts[0].image.at(3, 2, 1) = std::numeric_limits<float>::infinity();
  file.parts[0].image.at(4, 2, 1) = -0.f;
  file.parts[0].image.at(5, 2, 1) = std::numeric_limits<float>::denorm_min();
  file.attributes = {{"cameraModel", "A camera"}, {"expTime", "0.008"}, {"sheen.note", "two\nlines"}};
  write_exr(folder.path() / "a.exr", file);
  const ExrFile again = read_exr(folder.path() / "a.exr");
  ASSERT_EQ(again.parts.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(again.parts[i].name, file.parts[i].name);
    EXPECT_EQ(again.parts[i].channels, file.parts[i].channels);
    EXPECT_EQ(again.parts[i].image, file.parts[i].image);
    EXPECT_EQ(again.parts[i].precision, ExrPrecision::kFloat);
  }
  EXPECT_EQ(again.attributes, file.attributes);
  EXPECT_EQ(again.find("depth")->image.width(), 40);
  EXPECT_EQ(again.find("none"), nullptr);
}

/// Replaces the first bytes behind `before` in a small file.
void overwrite(const std::filesystem::path& file, const std::string& before, const std::string& bytes) {
  std::string text = read_file(file);
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos);
  text.replace(at + before.size(), bytes.size(), bytes);
  write_file(file, text);
}

TEST(Exr, AnAttributeThatClaimsMoreThanTheFileHoldsIsNotGivenTheMemory) {
  const TempFolder folder;
  const auto path = folder.path() / "a.exr";
  write_exr(path, {.parts = {{"a", {"Y"}, noise(6, 5, 1, 1)}, {"b", {"Y"}, noise(6, 5, 1, 1)}},
                   .attributes = {{"note", "n"}}});
  overwrite(path, std::string("note\0string\0", 12), "\xff\xff\xff\x7f");
  expect_error([&] { read_exr(path); }, {"a.exr", "\"note\"", "2147483647 bytes, more than the file holds"});
}

TEST(Exr, AnAttributeOfAnotherSizeThanItsTypeHasIsRefused) {
  // The library reads values of most types without regard to the size stated, and would take what follows for
  // attributes.
  const TempFolder folder;
  const auto path = folder.path() / "a.exr";
  const std::string headers[] = {std::string("compression\0compression\0", 24), std::string("channels\0chlist\0", 16),
                                 std::string("screenWindowWidth\0float\0", 24)};
  for (const std::string& header : headers) {
    write_exr(path, noise(6, 5, 1, 1));
    read_exr(path);
    overwrite(path, header, "\x05");
    expect_error([&] { read_exr(path); },
                 {"a.exr", '"' + header.substr(0, header.find('\0')) + '"', "claims 5 bytes, which a"});
  }
}

TEST(Exr, APreviewIsNotGivenTheMemoryOfThePixelsItClaims) {
  const TempFolder folder;
  const auto path = folder.path() / "a.exr";
  write_exr(path, {.parts = {{"a", {"Y"}, noise(6, 5, 1, 1)}}, .attributes = {{"preview", "123456789"}}});
  overwrite(path, std::string("preview\0", 8), std::string("preview\0\x08\0\0\0\0\x10\0\0\0\x10\0\0", 20));
  expect_error([&] { read_exr(path); }, {"a.exr", "\"preview\" claims 8 bytes, which a preview has not"});
}

TEST(Exr, AWideLineIsNotGivenTheMemoryOfItsWholeBlock) {
  const TempFolder folder;
  const auto path = folder.path() / "a.exr";
  write_exr(path, noise(2, 1, 3, 1));
  // Right edge of the data window: a million pixels in one line, of sixteen that are compressed together.
  overwrite(path, std::string("dataWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0", 29), std::string("\x3f\x42\x0f\0", 4));
  expect_error([&] { read_exr(path); }, {"a.exr", "1000000 x 1 pixels, more than the file can hold"});
}

TEST(Exr, OnlyWantedPartsAreRead) {
  const TempFolder folder;
  ExrFile file;
  for (const char* name : {"a", "b", "c"}) file.parts.push_back({name, {"Y"}, noise(6, 5, 1, 1)});
  file.attributes["note"] = "n";
  write_exr(folder.path() / "a.exr", file);
  std::vector<std::string> read;
  const ExrAttributes attributes = read_exr(
      folder.path() / "a.exr", [](const std::string& name) { return name != "b"; },
      [&](ExrPart&& part) { read.push_back(part.name); });
  EXPECT_EQ(read, (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(attributes.at("note"), "n");
}

TEST(Exr, HalfRoundsAndClampsToItsRange) {
  const TempFolder folder;
  ExrFile file;
  ImageF image(4, 1, 1);
  image.at(0, 0) = 1.0f / 3;
  image.at(1, 0) = 1e9f;
  image.at(2, 0) = -1e9f;
  image.at(3, 0) = std::numeric_limits<float>::quiet_NaN();
  file.parts.push_back({"y", {"Y"}, image, ExrPrecision::kHalf});
  write_exr(folder.path() / "a.exr", file);
  const ExrPart part = read_exr(folder.path() / "a.exr").parts[0];
  EXPECT_EQ(part.precision, ExrPrecision::kHalf);
  EXPECT_NEAR(part.image.at(0, 0), 1.0 / 3, 1.0 / 3 / 2048);
  EXPECT_EQ(part.image.at(1, 0), 65504);
  EXPECT_EQ(part.image.at(2, 0), -65504);
  EXPECT_TRUE(std::isnan(part.image.at(3, 0)));
}

TEST(Exr, ACropKeepsItsPlace) {
  const TempFolder folder;
  ExrFile file;
  file.parts.push_back({"crop", {"R", "G", "B"}, noise(8, 6, 3, 1), ExrPrecision::kFloat, 5, 7});
  write_exr(folder.path() / "a.exr", file);
  const ExrPart part = read_exr(folder.path() / "a.exr").parts[0];
  EXPECT_EQ(part.left, 5);
  EXPECT_EQ(part.top, 7);
  EXPECT_EQ(part.image, file.parts[0].image);
}

TEST(Exr, RefusesToWriteWhatNobodyCouldRead) {
  const TempFolder folder;
  const auto refused = [&](std::vector<ExrPart> parts, const std::vector<std::string>& words) {
    ExrFile file;
    file.parts = std::move(parts);
    expect_error([&] { write_exr(folder.path() / "a.exr", file); }, words);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  };
  const ImageF one(1, 1, 1), two(1, 1, 2);
  refused({}, {"a.exr", "part"});
  refused({{"a", {"Y"}, one}, {"a", {"Y"}, one}}, {"\"a\"", "name of its own"});
  refused({{"a", {"Y"}, {}}}, {"\"a\"", "no pixels"});
  refused({{"a", {"Y"}, two}}, {"\"a\"", "size that was announced"});
  refused({{"a", {"Y", "Y"}, two}}, {"\"a\"", "two channels"});
  expect_error([&] { write_exr(folder.path() / "none" / "a.exr", one); }, {"none", "cannot be written"});
  expect_error([&] { write_exr(folder.path() / "a.exr", two); }, {"a.exr", "2 channels"});
}

TEST(Exr, DamagedFilesAreErrors) {
  const TempFolder folder;
  ExrFile file;
  file.parts.push_back({"a", {"R", "G", "B"}, noise(20, 40, 3, 1)});
  file.parts.push_back({"b", {"Z"}, noise(20, 40, 1, 2)});
  write_exr(folder.path() / "whole.exr", file);
  const std::string whole = read_file(folder.path() / "whole.exr");
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97)
    EXPECT_THROW(read_exr(folder.write("cut.exr", whole.substr(0, size))), FileError) << size;
  expect_error([&] { read_exr(folder.write("cut.exr", whole.substr(0, whole.size() - 10))); }, {"cut.exr", "\"b\""});
  for (std::size_t i = 0; i < whole.size(); i += 1 + whole.size() / 397) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
    try {
      read_exr(folder.write("damaged.exr", damaged));
    } catch (const FileError&) {
      continue;  // either it is refused or the damage changes nothing but a value
    }
  }
  expect_error([&] { read_exr(folder.write("text.exr", "no picture at all")); },
               {"text.exr", "cannot be read as OpenEXR"});
  expect_error([&] { read_exr(folder.path() / "none.exr"); }, {"none.exr"});
}

TEST(Exr, ClaimedSizeIsNotBelieved) {
  const TempFolder folder;
  write_exr(folder.path() / "small.exr", noise(20, 40, 3, 1));
  std::string bytes = read_file(folder.path() / "small.exr");
  const std::size_t window = bytes.find(std::string("dataWindow\0box2i\0", 17)) + 17 + 4;
  ASSERT_LT(window, bytes.size());
  for (const std::size_t corner : {std::size_t(8), std::size_t(12)})  // right and bottom: 524287
    bytes.replace(window + corner, 4, std::string("\xff\xff\x07\x00", 4));
  expect_error([&] { read_exr(folder.write("huge.exr", bytes)); }, {"huge.exr"});
}

}  // namespace
}  // namespace sheen
