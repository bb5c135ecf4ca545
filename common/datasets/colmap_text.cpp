// SPDX-License-Identifier: Apache-2.0
#include <charconv>

#include "common/base/errors.h"
#include "common/datasets/colmap.h"

namespace sheen {

namespace {

/// Lines of a text and the words of the current one.
class Lines {
 public:
  Lines(const std::string& file, std::string_view text) : file_(file), rest_(text) {}

  /// False at the end.
  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    while (!line_.empty() && (line_.back() == '\r' || line_.back() == ' ')) line_.remove_suffix(1);
    ++number_;
    return true;
  }
  /// To the next line that says something.
  bool next_entry() {
    while (next())
      if (!line_.empty() && line_.front() != '#') return true;
    return false;
  }

  std::string_view rest_of_line() {
    line_.remove_prefix(std::min(line_.find_first_not_of(" \t"), line_.size()));
    return line_;
  }
  std::string_view word() {
    rest_of_line();
    const std::string_view word = line_.substr(0, line_.find_first_of(" \t"));
    line_.remove_prefix(word.size());
    return word;
  }
  template <typename T>
  T number(const char* field) {
    const std::string_view text = word();
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size())
      fail(std::string(field) + " is not a number");
    return value;
  }
  /// An image's second line, of three numbers for each of its points; it may be empty.
  void pass_points() {
    std::size_t words = 0;
    while (!rest_of_line().empty()) word(), ++words;
    if (words % 3 != 0)
      fail(
          "must be the points of the image before, X Y POINT3D_ID each: an image takes two lines, of which the second "
          "may be empty");
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(file_, "line " + std::to_string(number_) + ": " + what);
  }

 private:
  const std::string& file_;
  std::string_view rest_, line_;
  std::size_t number_ = 0;
};

}  // namespace

ColmapCameras parse_colmap_cameras_text(const std::string& file, std::string_view text) {
  ColmapCameras cameras;
  Lines lines(file, text);
  while (lines.next_entry()) {
    const auto id = lines.number<std::uint32_t>("CAMERA_ID");
    const std::string_view model = lines.word();
    const double width = lines.number<double>("WIDTH"), height = lines.number<double>("HEIGHT");
    std::vector<double> parameters;
    while (!lines.rest_of_line().empty()) parameters.push_back(lines.number<double>("PARAMS"));
    try {
      if (!cameras.emplace(id, colmap_camera(colmap_model_id(model), width, height, parameters)).second)
        lines.fail("camera " + std::to_string(id) + " is listed twice");
    } catch (const FileError&) {
      throw;
    } catch (const Error& error) {
      lines.fail("camera " + std::to_string(id) + " (" + std::string(model.substr(0, 40)) + "): " + error.what());
    }
  }
  return cameras;
}

std::vector<ColmapImage> parse_colmap_images_text(const std::string& file, std::string_view text) {
  std::vector<ColmapImage> images;
  Lines lines(file, text);
  while (lines.next_entry()) {
    ColmapImage image;
    lines.number<std::uint32_t>("IMAGE_ID");
    for (const int i : {0, 1, 2, 3}) image.rotation_wxyz[i] = lines.number<double>("QW QX QY QZ");
    for (const int i : {0, 1, 2}) image.translation[i] = lines.number<double>("TX TY TZ");
    image.camera_id = lines.number<std::uint32_t>("CAMERA_ID");
    image.name = lines.rest_of_line();
    if (image.name.empty()) lines.fail("NAME is missing");
    images.push_back(std::move(image));
    if (lines.next()) lines.pass_points();
  }
  return images;
}

}  // namespace sheen
