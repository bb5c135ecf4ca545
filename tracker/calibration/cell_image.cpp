// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/cell_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exif.h"

namespace sheen {
namespace {

constexpr int kSmallestCell = 8;  ///< pixels

/// Channel of a site of a colour filter array: 0 red, 1 green, 2 blue.
int channel_of_site(const std::string& mosaic, int x, int y) {
  const bool red_x = mosaic == "GR" || mosaic == "BG", red_y = mosaic == "GB" || mosaic == "BG";
  return ((x & 1) != int(red_x)) + ((y & 1) != int(red_y));
}

struct Sum {
  double sum = 0, squares = 0, count = 0;
  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  CellValue value() const {
    const double mean = sum / count, variance = std::max(0.0, (squares - sum * mean) / std::max(1.0, count - 1));
    return {static_cast<float>(mean), static_cast<float>(variance), static_cast<float>(count)};
  }
};

ImageF full_scale_one(const cv::Mat& image, double white) {
  const int channels = image.channels() == 1 ? 1 : 3;
  ImageF values(image.cols, image.rows, channels);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int c = 0; c < channels; ++c) {
        const int stored = image.channels() * x + (channels == 1 ? 0 : 2 - c);  // OpenCV keeps blue first
        const double value =
            image.depth() == CV_8U ? image.ptr<std::uint8_t>(y)[stored] : image.ptr<std::uint16_t>(y)[stored];
        values.at(x, y, c) = static_cast<float>(value / white);
      }
  return values;
}

}  // namespace

double CellValue::mean_variance(int levels) const {
  const double step2 = 1.0 / (double(levels) * levels);
  return variance / count + step2 / 12 * std::max(0.0, 1 - variance / (0.25 * step2));
}

CellImage cells_of(const ImageF& values, const std::string& mosaic, int across) {
  CellImage image;
  image.size = {values.width(), values.height()};
  image.channels = mosaic.empty() ? values.channels() : 3;
  const int longer = std::max(values.width(), values.height());
  image.cell_px = std::max(kSmallestCell, (longer / across + 1) & ~1);
  image.columns = values.width() / image.cell_px;
  image.rows = values.height() / image.cell_px;
  image.values.reserve(std::size_t(image.cells()) * image.channels);
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.columns; ++column) {
      std::array<Sum, 3> sums;
      for (int y = row * image.cell_px; y < (row + 1) * image.cell_px; ++y)
        for (int x = column * image.cell_px; x < (column + 1) * image.cell_px; ++x)
          for (int c = 0; c < values.channels(); ++c) {
            const int channel = mosaic.empty() ? c : channel_of_site(mosaic, x, y);
            sums[channel].add(values.at(x, y, c));
          }
      for (int c = 0; c < image.channels; ++c) image.values.push_back(sums[c].value());
    }
  image.highest = *std::max_element(values.data(), values.data() + values.size());
  return image;
}

CellImage read_cells(const std::filesystem::path& file, const ValueFormat& format, int across) {
  const std::string bytes = read_file(file);
  cv::Mat image;
  try {
    image = cv::imdecode(cv::Mat(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {  // as of an image that cannot be decoded
  }
  if (image.empty()) throw FileError(file.string(), "is no image that can be read; give PNG, TIFF or JPEG");
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    throw FileError(file.string(), "has neither 8 nor 16 bits per value");
  if (!format.mosaic.empty() && image.channels() != 1)
    throw FileError(file.string(), "has colours already; --mosaic is for files with one channel");
  if (std::min(image.cols, image.rows) < 4 * kSmallestCell)
    throw FileError(file.string(), "is too small: 32 x 32 pixels are the least");
  const int levels = image.depth() == CV_8U ? 255 : (1 << (format.bits > 0 ? format.bits : 16)) - 1;
  CellImage cells = cells_of(full_scale_one(image, levels), format.mosaic, across);
  if (cells.highest > 1)
    throw FileError(file.string(), "holds values beyond " + std::to_string(levels) + ", the most that --bits allows");
  cells.levels = levels;
  cells.name = file.filename().string();
  if (const auto exif = read_exif_exposure(bytes))
    cells.exposure_s = exif->exposure_s * (exif->iso > 0 ? exif->iso / 100 : 1);
  return cells;
}

}  // namespace sheen
