// SPDX-License-Identifier: Apache-2.0
#include "common/plot/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/plot/gnuplot.h"

namespace sheen {
namespace {

// Okabe and Ito's colours: told apart by people who are colour-blind.
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#555555"};
constexpr std::size_t kLegendLine = 24;  // pixels; beside the curves, a long legend would leave them no room
constexpr int kPoints[] = {7, 5, 9, 13, 11, 6, 4};

std::string number(double value) {
  return format("%.9g", value);
}

/// Marks at 1, 2 and 5 of every decade: gnuplot's own leave an axis of less than a decade without any.
void write_log_tics(std::ostream& out, char name) {
  const char* separator = "";
  out << "set logscale " << name << "\nset " << name << "tics (";
  for (int decade = -9; decade <= 12; ++decade)
    for (const int digit : {1, 2, 5}) {
      out << separator << number(digit * std::pow(10.0, decade));
      separator = ", ";
    }
  out << ")\n";
}

void write_axis(std::ostream& out, char name, const PlotAxis& axis) {
  out << "set " << name << "label " << gnuplot_string(axis.label) << '\n';
  if (axis.log) write_log_tics(out, name);
  if (axis.log && name == 'x') out << "set xrange [*:*] noextend\n";
  if (axis.categories.empty()) return;
  out << "set " << name << "tics (";
  for (std::size_t i = 0; i < axis.categories.size(); ++i)
    out << (i > 0 ? ", " : "") << gnuplot_string(axis.categories[i]) << ' ' << i;
  out << ')' << (axis.upright_categories ? " rotate by 90 right" : "") << "\nset " << name
      << "range [-0.6:" << static_cast<double>(axis.categories.size()) - 0.4 << "]\n";
}

const char* colour_of(std::size_t series) {
  return kColours[series % std::size(kColours)];
}

std::string drawing(const PlotSeries& series, std::size_t i) {
  const std::string colour = std::string(" lc rgb '") + colour_of(i) + "'";
  const std::string point =
      " pt " + std::to_string(kPoints[(i + i / std::size(kColours)) % std::size(kPoints)]) + " ps 0.7";
  switch (series.style) {
    case PlotStyle::kLine:
      return "with lines lw 2" + colour;
    case PlotStyle::kDashed:
      return "with lines lw 1.5 dt 2" + colour;
    case PlotStyle::kMarkers:
      return "with points" + point + colour;
    case PlotStyle::kLineAndMarkers:
      return "with linespoints lw 2" + point + colour;
    case PlotStyle::kBars:
      return "with boxes fs solid 0.85 noborder" + colour;
  }
  return {};
}

/// Of the x axis.
double middle_of(const Plot& plot) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const PlotSeries& series : plot.series)
    for (const double x : series.x) {
      lowest = std::min(lowest, x);
      highest = std::max(highest, x);
    }
  return plot.x.log ? std::sqrt(lowest * highest) : 0.5 * (lowest + highest);
}

std::string gnuplot_script(const Plot& plot, const std::filesystem::path& svg) {
  std::ostringstream out;
  out << "# Draws " << svg.filename().string() << ": gnuplot " << svg.stem().string() << ".gnuplot\n"
      << "set terminal svg noenhanced size 760," << 440 + kLegendLine * plot.series.size()
      << " font 'sans-serif,14' background '#ffffff'\n"
      << "set output " << gnuplot_string(svg.filename().string()) << "\nset title " << gnuplot_string(plot.title)
      << "\nset border 3 lc rgb '#555555'\nset tics nomirror\nset grid lc rgb '#dddddd' lw 1 lt 1\n"
      << "set key below left Left reverse samplen 2 spacing 1.3 maxcols 1\n"
      << "set offsets graph 0.03, graph 0.03, graph 0.06, graph 0.03\n";
  write_axis(out, 'x', plot.x);
  write_axis(out, 'y', plot.y);
  std::size_t bars = 0, bar = 0;
  for (const PlotSeries& series : plot.series) bars += series.style == PlotStyle::kBars;
  const double bar_width = 0.8 / static_cast<double>(std::max<std::size_t>(bars, 1));
  if (bars > 0) out << "set boxwidth " << bar_width << "\n";
  if (bars > 0 && !plot.y.log) out << "set yrange [0:*]\n";
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    const bool is_bar = series.style == PlotStyle::kBars;
    const double shift = is_bar ? (static_cast<double>(bar++) - 0.5 * static_cast<double>(bars - 1)) * bar_width : 0;
    out << "$series" << i << " << end\n";
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!std::isfinite(series.x[k]) || !std::isfinite(series.y[k])) continue;
      out << number(series.x[k] + shift) << ' ' << number(series.y[k]);
      if (!series.bars.empty()) out << ' ' << number(series.bars[k]);
      if (!series.labels.empty()) out << " \"" << series.labels[k] << '"';
      out << '\n';
    }
    out << "end\n";
  }
  const double middle = middle_of(plot);
  out << "plot ";
  const char* separator = "";
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    out << separator << "$series" << i << " using 1:2 " << drawing(series, i) << " title "
        << gnuplot_string(series.name);
    if (!series.bars.empty())
      // Not yerrorbars, which clear the place of the marker.
      out << ", \\\n  $series" << i << " using 1:($2 - $3):(0):(2 * $3) with vectors nohead lw 1 lc rgb '"
          << colour_of(i) << "' notitle";
    if (!series.labels.empty())  // towards the middle, where there is room
      for (const bool right : {false, true})
        out << ", \\\n  $series" << i << " using ($1 " << (right ? ">" : "<=") << ' ' << number(middle)
            << " ? $1 : NaN):2:3 with labels " << (right ? "right offset -0.8,0.5" : "left offset 0.8,0.5")
            << " font ',10' tc rgb '#555555' notitle";
    separator = ", \\\n  ";
  }
  for (std::size_t i = 0; i < plot.levels.size(); ++i) {
    out << separator << number(plot.levels[i].y) << " with lines lw 1.5 dt (8,6) lc rgb '"
        << (i % 2 == 0 ? "#000000" : "#999999") << "' title " << gnuplot_string(plot.levels[i].name);
    separator = ", \\\n  ";
  }
  out << '\n';
  return out.str();
}

}  // namespace

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

std::string plot_csv(const Plot& plot) {
  const bool bars =
      std::any_of(plot.series.begin(), plot.series.end(), [](const PlotSeries& s) { return !s.bars.empty(); });
  std::string out =
      "series," + csv_field(plot.x.label) + ',' + csv_field(plot.y.label) + (bars ? ",label,bar\n" : ",label\n");
  const auto line = [&](const std::string& name, const std::string& x, double y, const std::string& label,
                        const std::string& bar) {
    out += csv_field(name) + ',' + csv_field(x) + ',' + number(y) + ',' + csv_field(label);
    out += bars ? ',' + bar + '\n' : "\n";
  };
  for (const PlotSeries& series : plot.series)
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      const bool named = !plot.x.categories.empty();
      line(series.name, named ? plot.x.categories.at(static_cast<std::size_t>(series.x[k])) : number(series.x[k]),
           series.y[k], series.labels.empty() ? std::string() : series.labels[k],
           series.bars.empty() ? std::string() : number(series.bars[k]));
    }
  for (const PlotLevel& level : plot.levels) line(level.name, "", level.y, "", "");
  return out;
}

PlotFiles write_plot(const Plot& plot, const std::filesystem::path& stem) {
  const auto with_suffix = [&](const char* suffix) { return std::filesystem::path(stem.string() + suffix); };
  const std::filesystem::path script = with_suffix(".gnuplot");
  write_file(with_suffix(".csv"), plot_csv(plot));
  write_file(script, gnuplot_script(plot, with_suffix(".svg")));

  return run_gnuplot(script);
}

}  // namespace sheen
