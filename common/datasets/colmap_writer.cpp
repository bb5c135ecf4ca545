// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/colmap_writer.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/datasets/colmap.h"

namespace sheen {
namespace {

/// The same values as words of a text and as little-endian bytes.
struct Twins {
  std::string text, binary;

  template <typename T>
  void bytes(T value) {
    static_assert(std::endian::native == std::endian::little);
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    binary.append(raw, sizeof(T));
  }
  void word(const std::string& word) {
    if (!text.empty() && text.back() != '\n') text += ' ';
    text += word;
  }
  template <typename T>
  void integer(std::uint64_t value) {
    word(std::to_string(value));
    bytes(static_cast<T>(value));
  }
  void number(double value) {
    word(format("%.17g", value));
    bytes(value);
  }
  void end_line() { text += '\n'; }

  void write(const std::filesystem::path& stem) const {
    write_file(stem.string() + ".txt", text);
    write_file(stem.string() + ".bin", binary);
  }
};

Twins begin(const std::string& columns, std::size_t count) {
  Twins file;
  file.text = "# " + columns + "\n";
  file.bytes(static_cast<std::uint64_t>(count));
  return file;
}

void write_cameras(const std::filesystem::path& folder, const std::vector<Camera>& cameras) {
  Twins file = begin("CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]", cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const ColmapParameters camera = colmap_parameters(cameras[i]);
    file.integer<std::uint32_t>(i + 1);
    file.word(camera.model);
    file.bytes(static_cast<std::int32_t>(colmap_model_id(camera.model)));
    file.integer<std::uint64_t>(static_cast<std::uint64_t>(cameras[i].width));
    file.integer<std::uint64_t>(static_cast<std::uint64_t>(cameras[i].height));
    for (const double value : camera.values) file.number(value);
    file.end_line();
  }
  file.write(folder / "cameras");
}

void write_images(const std::filesystem::path& folder, const std::vector<DatasetView>& views,
                  const std::vector<Camera>& cameras) {
  Twins file =
      begin("IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# POINTS2D[] as X Y POINT3D_ID (here none)", views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const DatasetView& view = views[i];
    if (view.name.empty() || view.name.find_first_of(std::string(" \t\r\n\0", 5)) != std::string::npos)
      throw FileError((folder / "images.txt").string(), "cannot hold the name \"" + view.name + "\"");
    file.integer<std::uint32_t>(i + 1);
    const Eigen::Quaterniond& q = view.camera_from_object.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) file.number(value);
    for (const double value : view.camera_from_object.translation) file.number(value);
    const auto camera = std::find(cameras.begin(), cameras.end(), view.camera) - cameras.begin();
    file.integer<std::uint32_t>(static_cast<std::uint64_t>(camera) + 1);
    file.word(view.name);
    file.binary += view.name + '\0';
    file.end_line();
    file.end_line();  // of its points
    file.bytes(std::uint64_t{0});
  }
  file.write(folder / "images");
}

void write_points(const std::filesystem::path& folder, std::span<const ColouredPoint> points) {
  constexpr double kUnknownError = -1;
  Twins file = begin("POINT3D_ID X Y Z R G B ERROR TRACK[] as IMAGE_ID POINT2D_IDX (here none)", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    file.integer<std::uint64_t>(i + 1);
    for (const double value : points[i].position) file.number(value);
    for (const std::uint8_t value : points[i].colour) file.integer<std::uint8_t>(value);
    file.number(kUnknownError);
    file.bytes(std::uint64_t{0});
    file.end_line();
  }
  file.write(folder / "points3D");
}

void write_held_out(const std::filesystem::path& folder, const std::vector<DatasetView>& views) {
  const auto all = [&](Purpose purpose) {
    return std::all_of(views.begin(), views.end(), [&](const DatasetView& view) { return view.purpose == purpose; });
  };
  std::string names;
  for (const DatasetView& view : views)
    if (view.purpose == Purpose::kHeldOut) names += view.name + "\n";
  if (!names.empty() || all(Purpose::kTraining)) write_file(folder / kColmapHeldOut, names);
}

}  // namespace

void write_colmap(const std::filesystem::path& folder, const std::vector<DatasetView>& views,
                  std::span<const ColouredPoint> points) {
  if (views.empty()) throw FileError(folder.string(), "cannot be written: there are no views");
  std::vector<Camera> cameras;
  for (const DatasetView& view : views)
    if (std::find(cameras.begin(), cameras.end(), view.camera) == cameras.end()) cameras.push_back(view.camera);
  write_cameras(folder, cameras);
  write_images(folder, views, cameras);
  write_points(folder, points);
  write_held_out(folder, views);
}

}  // namespace sheen
