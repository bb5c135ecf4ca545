// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/plot/plot.h"

namespace sheen {

/// A value at each place of a grid over an image, drawn as colours, the image's first row at the top.
struct HeatMap {
  std::string title;
  std::string value;           ///< what the colours mean, with its unit
  int width = 0, height = 0;   ///< of the image, pixels
  int columns = 0, rows = 0;   ///< the grid spans the image from its first pixel to its last
  std::vector<double> values;  ///< row by row; what is not finite is left white
  struct Point {
    double x = 0, y = 0;
  };
  std::vector<Point> points;  ///< drawn over it, small
  double most = 0;            ///< where the colours end; 0: at the greatest value
};

/// Writes STEM.csv (x, y, value), STEM.gnuplot and, by running gnuplot on it, STEM.svg. Throws FileError.
PlotFiles write_heat_map(const HeatMap& map, const std::filesystem::path& stem);

}  // namespace sheen
