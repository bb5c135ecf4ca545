// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstring>

#include "common/base/errors.h"
#include "common/datasets/colmap.h"

namespace sheen {

namespace {

/// Little-endian values one after the other; throws at the end of the file.
class Reader {
 public:
  Reader(const std::string& file, std::string_view bytes) : file_(file), rest_(bytes) {}

  template <typename T>
  T take(const char* field) {
    static_assert(std::endian::native == std::endian::little);
    T value;
    std::memcpy(&value, skip(sizeof(T), field).data(), sizeof(T));
    return value;
  }
  std::string_view skip(std::uint64_t size, const char* field) {
    if (size > rest_.size()) fail(std::string("the file is cut off at ") + field);
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::string_view text(const char* field) {
    const std::size_t end = rest_.find('\0');
    if (end == std::string_view::npos) fail(std::string("the file is cut off at ") + field);
    return skip(end + 1, field).substr(0, end);
  }
  void begin_entry(const char* kind, std::uint64_t index) { entry_ = std::string(kind) + " " + std::to_string(index); }
  [[noreturn]] void fail(const std::string& what) const { throw FileError(file_, entry_ + ": " + what); }

 private:
  const std::string& file_;
  std::string_view rest_;
  std::string entry_ = "count";
};

}  // namespace

ColmapCameras parse_colmap_cameras_binary(const std::string& file, std::string_view bytes) {
  ColmapCameras cameras;
  Reader in(file, bytes);
  const auto count = in.take<std::uint64_t>("the number of cameras");
  for (std::uint64_t i = 0; i < count; ++i) {
    in.begin_entry("entry", i);
    const auto id = in.take<std::uint32_t>("camera_id");
    const auto model = in.take<std::int32_t>("model_id");
    const auto width = in.take<std::uint64_t>("width"), height = in.take<std::uint64_t>("height");
    std::vector<double> parameters;
    for (int p = 0; p < colmap_parameter_count(model); ++p) parameters.push_back(in.take<double>("params"));
    try {
      if (!cameras.emplace(id, colmap_camera(model, double(width), double(height), parameters)).second)
        in.fail("camera " + std::to_string(id) + " is listed twice");
    } catch (const FileError&) {
      throw;
    } catch (const Error& error) {
      in.fail("camera " + std::to_string(id) + " (model " + std::to_string(model) + "): " + error.what());
    }
  }
  return cameras;
}

std::vector<ColmapImage> parse_colmap_images_binary(const std::string& file, std::string_view bytes) {
  constexpr std::uint64_t kPointBytes = 24;
  std::vector<ColmapImage> images;
  Reader in(file, bytes);
  const auto count = in.take<std::uint64_t>("the number of images");
  for (std::uint64_t i = 0; i < count; ++i) {
    in.begin_entry("entry", i);
    ColmapImage image;
    in.take<std::uint32_t>("image_id");
    for (const int k : {0, 1, 2, 3}) image.rotation_wxyz[k] = in.take<double>("qvec");
    for (const int k : {0, 1, 2}) image.translation[k] = in.take<double>("tvec");
    image.camera_id = in.take<std::uint32_t>("camera_id");
    image.name = in.text("name");
    if (image.name.empty()) in.fail("name is missing");
    const auto points = in.take<std::uint64_t>("the number of points");
    if (points > bytes.size() / kPointBytes) in.fail("the file is cut off at points2D");
    in.skip(points * kPointBytes, "points2D");
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace sheen
