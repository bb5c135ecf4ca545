// SPDX-License-Identifier: Apache-2.0
#include "common/plot/heat_map.h"

#include <cmath>
#include <sstream>

#include "common/base/files.h"
#include "common/base/format.h"
#include "common/plot/gnuplot.h"

namespace sheen {
namespace {

std::string number(double value) {
  return std::isfinite(value) ? format("%.6g", value) : "NaN";
}

double place(int i, int count, int size) {
  return count > 1 ? double(i) * (size - 1) / (count - 1) : 0;
}

std::string table(const HeatMap& map) {
  std::string out = "x,y," + csv_field(map.value) + "\n";
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      out += number(place(column, map.columns, map.width)) + ',' + number(place(row, map.rows, map.height)) + ',' +
             number(map.values[std::size_t(row * map.columns + column)]) + '\n';
  return out;
}

std::string script_of(const HeatMap& map, const std::filesystem::path& svg) {
  std::ostringstream out;
  out << "# Draws " << svg.filename().string() << ": gnuplot " << svg.stem().string() << ".gnuplot\n"
      << "set terminal svg noenhanced size 760,560 font 'sans-serif,14' background '#ffffff'\n"
      << "set output " << gnuplot_string(svg.filename().string()) << "\nset title " << gnuplot_string(map.title)
      << "\nset xrange [-0.5:" << map.width - 0.5 << "]\nset yrange [" << map.height - 0.5
      << ":-0.5]\nset size ratio -1\nset tics out nomirror\nset xlabel 'x (px)'\nset ylabel 'y (px)'\n"
      << "set cblabel " << gnuplot_string(map.value) << "\nset cbrange [0:";
  if (map.most > 0)
    out << number(map.most);
  else
    out << '*';
  // From light to dark in one hue: told apart in grey, too.
  out << "]\nset palette defined (0 '#f7fbff', 0.25 '#c6dbef', 0.5 '#6baed6', 0.75 '#2171b5', 1 '#08306b')\n"
      << "$values << end\n";
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      out << number(place(column, map.columns, map.width)) << ' ' << number(place(row, map.rows, map.height)) << ' '
          << number(map.values[std::size_t(row * map.columns + column)]) << '\n';
  out << "end\n";
  if (!map.points.empty()) {
    out << "$points << end\n";
    for (const HeatMap::Point& point : map.points) out << number(point.x) << ' ' << number(point.y) << '\n';
    out << "end\n";
  }
  out << "plot $values using 1:2:3 with image notitle";
  if (!map.points.empty()) out << ", $points using 1:2 with points pt 7 ps 0.15 lc rgb '#D55E00' notitle";
  out << '\n';
  return out.str();
}

}  // namespace

PlotFiles write_heat_map(const HeatMap& map, const std::filesystem::path& stem) {
  const auto with_suffix = [&](const char* suffix) { return std::filesystem::path(stem.string() + suffix); };
  const std::filesystem::path script = with_suffix(".gnuplot");
  write_file(with_suffix(".csv"), table(map));
  write_file(script, script_of(map, with_suffix(".svg")));
  return run_gnuplot(script);
}

}  // namespace sheen
