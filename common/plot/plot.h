// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheen {

enum class PlotStyle { kLine, kMarkers, kLineAndMarkers, kDashed, kBars };

/// Points that belong together; x, y and (where there are any) labels and bars are of one length. A point whose x or y
/// is not finite is left out of the picture and stands in the table.
struct PlotSeries {
  std::string name;
  std::vector<double> x, y;
  PlotStyle style = PlotStyle::kLineAndMarkers;
  std::vector<std::string> labels;  ///< beside the points
  std::vector<double> bars;         ///< half lengths of error bars; empty = none

  void add(double at, double value) {
    x.push_back(at);
    y.push_back(value);
  }
};

struct PlotAxis {
  std::string label;  ///< with its unit
  bool log = false;
  std::vector<std::string> categories;  ///< names of the places 0, 1, 2, ... of an axis that has no scale
  bool upright_categories = false;      ///< their names stand upright: many, or long ones
};

/// A level to compare with, dashed across the plot: what a paper claims, a goal.
struct PlotLevel {
  std::string name;
  double y = 0;
};

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  std::vector<PlotLevel> levels;
};

/// What became of a plot: its table always, its picture where gnuplot is installed.
enum class PlotFiles { kDrawn, kTableOnly };

/// Writes STEM.csv (series, x, y, label, and bar where there are any), STEM.gnuplot (the whole plot, to draw or restyle
/// by hand) and, by running gnuplot on it, STEM.svg. Throws FileError.
PlotFiles write_plot(const Plot& plot, const std::filesystem::path& stem);

/// The table: one line per point, quoted as RFC 4180 says.
std::string plot_csv(const Plot& plot);

/// A field of such a table.
std::string csv_field(const std::string& text);

/// What to tell a person whose plots were not drawn.
inline constexpr const char* kInstallGnuplot =
    "gnuplot is not installed, so no SVG was drawn: apt install gnuplot-nox, then run gnuplot on the .gnuplot files";

}  // namespace sheen
