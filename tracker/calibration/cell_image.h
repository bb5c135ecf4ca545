// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/image/image.h"

namespace sheen {

/// How the files of a photometric calibration are to be read.
struct ValueFormat {
  int bits = 0;        ///< of a 16-bit file's values; 0: all 16
  std::string mosaic;  ///< "RG", "GR", "GB" or "BG": the colours of the first two sites of a file with one channel,
                       ///< which is a colour filter array; empty: grey, or all colours
};

/// Mean of a channel's values in a cell, of full scale.
struct CellValue {
  float mean = 0;
  float variance = 0;  ///< of single pixels
  float count = 0;     ///< of pixels

  /// Of the mean; with what is left of rounding to `levels` steps where hardly any noise spreads the pixels over them.
  double mean_variance(int levels) const;
};

/// An image as means over square cells: what noise leaves of a value, and how much noise there is.
struct CellImage {
  std::string name;
  double exposure_s = 0;  ///< 0: not known; times the gain, where the file says that
  ImageSize size;         ///< of the image
  int cell_px = 0;        ///< side of a cell
  int columns = 0, rows = 0;
  int channels = 0;               ///< 1, or red, green, blue
  std::vector<CellValue> values;  ///< row by row, channels together
  double highest = 0;             ///< value of any pixel
  int levels = 255;               ///< values that the file can tell apart, less one

  const CellValue& at(int column, int row, int channel) const {
    return values[(std::size_t(row) * columns + column) * channels + channel];
  }
  int cells() const { return columns * rows; }
  double x(int column) const { return (column + 0.5) * cell_px - 0.5; }  ///< pixels, of a cell's centre
  double y(int row) const { return (row + 0.5) * cell_px - 0.5; }
};

/// From the pixels of full scale 1 (1 or 3 channels; with `mosaic` 1). `across`: cells along the longer side, at most.
CellImage cells_of(const ImageF& values, const std::string& mosaic, int across);

/// Reads PNG, TIFF or JPEG of 8 or 16 bits. The exposure is what EXIF says. Throws FileError.
CellImage read_cells(const std::filesystem::path& file, const ValueFormat& format, int across);

}  // namespace sheen
