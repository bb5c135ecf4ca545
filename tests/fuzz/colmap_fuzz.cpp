// SPDX-License-Identifier: Apache-2.0
// Whatever COLMAP's files hold: sound cameras and named images, or a FileError; and the binary file says what its twin
// in text does.
#include "common/datasets/colmap.h"

#include <cmath>
#include <optional>
#include <type_traits>

#include "common/base/errors.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace sheen;
using fuzz::demand;
using fuzz::Input;

void expect_sound(const ColmapCameras& cameras) {
  for (const auto& [id, camera] : cameras) demand(validation_error(camera).empty(), "an unsound camera");
}

void expect_sound(const std::vector<ColmapImage>& images) {
  for (const ColmapImage& image : images) {
    demand(!image.name.empty(), "an image without a name");
    try {
      const Rigid3 pose = colmap_pose(image);
      demand(pose.matrix().allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6, "an unsound pose");
    } catch (const Error&) {
    }
  }
}

template <auto kParse>
void arbitrary(Input in) {
  expect_sound(kParse("fuzz", in.text()));
}

/// One entry, written in both forms.
struct Twins {
  std::string text, binary;

  template <typename T>
  void add(T value) {
    binary.append(reinterpret_cast<const char*>(&value), sizeof value);
    char word[40];
    if constexpr (std::is_floating_point_v<T>)
      std::snprintf(word, sizeof word, "%.17g ", value);
    else
      std::snprintf(word, sizeof word, "%llu ", static_cast<unsigned long long>(value));
    text += word;
  }
};

template <typename Parse>
auto parse_or_nothing(Parse parse, const std::string& bytes) -> std::optional<decltype(parse("", bytes))> {
  try {
    return parse("fuzz", bytes);
  } catch (const FileError&) {
    return std::nullopt;
  }
}

void camera_in_both_forms(Input in) {
  constexpr const char* kNames[] = {"SIMPLE_PINHOLE",
                                    "PINHOLE",
                                    "SIMPLE_RADIAL",
                                    "RADIAL",
                                    "OPENCV",
                                    "OPENCV_FISHEYE",
                                    "FULL_OPENCV",
                                    "FOV",
                                    "SIMPLE_RADIAL_FISHEYE",
                                    "RADIAL_FISHEYE",
                                    "THIN_PRISM_FISHEYE"};
  Twins twins;
  twins.binary.append("\1\0\0\0\0\0\0\0", 8);
  twins.add<std::uint32_t>(in.byte());
  const std::int32_t model = in.byte() % std::size(kNames);
  twins.binary.append(reinterpret_cast<const char*>(&model), sizeof model);
  twins.text += std::string(kNames[model]) + " ";
  for (int side = 0; side < 2; ++side) twins.add<std::uint64_t>(in.size16());
  // Numbers that a camera may have, and any others.
  for (int i = 0; i < colmap_parameter_count(model); ++i)
    twins.add<double>(in.byte() % 4 ? in.byte() * 4.0 - in.byte() / 256.0 : in.bits<double>());
  const auto text = parse_or_nothing(parse_colmap_cameras_text, twins.text);
  const auto binary = parse_or_nothing(parse_colmap_cameras_binary, twins.binary);
  demand(text.has_value() == binary.has_value(), "only one form of a camera is refused");
  if (!text) return;
  expect_sound(*text);
  demand(*text == *binary, "the forms of a camera differ");
}

void image_in_both_forms(Input in) {
  Twins twins;
  twins.binary.append("\1\0\0\0\0\0\0\0", 8);
  twins.add<std::uint32_t>(in.byte());
  for (int i = 0; i < 7; ++i) twins.add<double>(in.byte() % 4 ? in.byte() / 255.0 : in.bits<double>());
  twins.add<std::uint32_t>(in.byte());
  // A line of text holds neither line ends nor blanks at its ends, nor a byte 0 in a name.
  std::string name = "n";
  for (const char c : in.text()) name += c == '\n' || c == '\r' || c == '\0' ? '_' : c;
  name += "n";
  twins.text += name + "\n\n";
  twins.binary.append(name.c_str(), name.size() + 1);
  twins.binary.append(8, '\0');
  const auto text = parse_or_nothing(parse_colmap_images_text, twins.text);
  const auto binary = parse_or_nothing(parse_colmap_images_binary, twins.binary);
  if (!text) return;  // not a number, which the text may not hold
  demand(binary.has_value(), "only the binary form of an image is refused");
  expect_sound(*text);
  const ColmapImage &a = text->at(0), &b = binary->at(0);
  demand(a.name == b.name && a.camera_id == b.camera_id, "the forms of an image differ");
  if (a.rotation_wxyz.allFinite() && a.translation.allFinite())
    demand(a.rotation_wxyz == b.rotation_wxyz && a.translation == b.translation, "the forms of a pose differ");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr void (*kTargets[])(Input) = {arbitrary<parse_colmap_cameras_binary>,
                                         arbitrary<parse_colmap_images_binary>,
                                         arbitrary<parse_colmap_cameras_text>,
                                         arbitrary<parse_colmap_images_text>,
                                         camera_in_both_forms,
                                         image_in_both_forms};
  Input in{{data, size}};
  const std::size_t target = in.byte() % std::size(kTargets);
  try {
    kTargets[target](in);
  } catch (const FileError&) {
  }
  return 0;
}
