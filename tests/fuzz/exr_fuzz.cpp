// SPDX-License-Identifier: Apache-2.0
// Whatever an EXR file holds: parts with as many pixels as they claim, which written again are read as the same bits,
// or a FileError.
#include <cmath>
#include <set>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exr.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::Input;

const TempFolder& folder() {
  static const TempFolder folder;
  return folder;
}

ImageF ramp(int width, int height, int channels) {
  ImageF image(width, height, channels);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = 0.37f * static_cast<float>(i) - 1;
  return image;
}

/// Two parts of both precisions, one of them cropped.
std::string valid_file() {
  const auto path = folder().path() / "valid.exr";
  write_exr(path, {.parts = {{"beauty", {"R", "G", "B"}, ramp(5, 4, 3), ExrPrecision::kHalf},
                             {"depth", {"Z"}, ramp(3, 2, 1), ExrPrecision::kFloat, 1, 1}},
                   .attributes = {{"cameraModel", "sim"}, {"expTime", "0.004"}}});
  return read_file(path);
}

/// Names that a file of several parts needs, and a picture that begins with part 0.
bool can_be_written(const ExrFile& file) {
  std::set<std::string> names;
  std::size_t pixels = 0;
  for (const ExrPart& part : file.parts) {
    if (part.name.empty() || !names.insert(part.name).second) return false;
    pixels += part.image.size();
  }
  return file.parts[0].left == 0 && file.parts[0].top == 0 && pixels < 100'000;
}

bool same_values(const ImageF& a, const ImageF& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a.data()[i] != b.data()[i] && !(std::isnan(a.data()[i]) && std::isnan(b.data()[i]))) return false;
  return a.width() == b.width() && a.height() == b.height() && a.channels() == b.channels();
}

void expect_same(const ExrFile& file, const ExrFile& again) {
  demand(again.parts.size() == file.parts.size(), "another number of parts");
  for (std::size_t i = 0; i < file.parts.size(); ++i) {
    const ExrPart &a = file.parts[i], &b = again.parts[i];
    demand(a.name == b.name && a.channels == b.channels, "another part");
    demand(same_values(a.image, b.image), "other values");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kValid = valid_file();
  Input in{{data, size}};
  std::string bytes;
  if (in.byte() % 2) {
    bytes = in.text();
  } else {
    bytes = kValid;
    while (in.rest.size() >= 4) fuzz::damage_once(bytes, in);
  }
  try {
    const ExrFile file = read_exr(folder().write("input.exr", bytes));
    demand(!file.parts.empty(), "no part");
    for (const ExrPart& part : file.parts)
      demand(!part.image.empty() && part.image.channels() == static_cast<int>(part.channels.size()), "missing pixels");
    if (!can_be_written(file)) return 0;
    write_exr(folder().path() / "again.exr", file);
    expect_same(file, read_exr(folder().path() / "again.exr"));
  } catch (const FileError&) {
  }
  return 0;
}
