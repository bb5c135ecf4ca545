// SPDX-License-Identifier: Apache-2.0
#include "common/stage/stage_sheet.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/stage/tag_pattern.h"

namespace sheen {
namespace {

constexpr double kPageMargin = 10, kFooter = 18;  // mm
constexpr double kScaleBar = 100;                 // mm
constexpr double kPointsPerMm = 72 / 25.4;

/// Millimetres from the page's top left corner, y down.
using Point = Eigen::Vector2d;

struct Polygon {
  std::vector<Point> corners;
  double grey;  // 0 black
};
struct Stroke {
  Point from, to;
  double width, grey;
};
struct Label {
  Point baseline;  // left end of the text
  double height;
  std::string text;
};

/// What stands on the page, apart from any file format.
struct Sheet {
  double width = 0, height = 0;  // mm
  std::vector<Polygon> polygons;
  std::vector<Stroke> strokes;
  std::vector<Label> labels;
};

std::string number(double value) {
  return format("%.4f", value);
}

/// The black cells of a tag: runs of a row, each a little polygon, so that no seam shows inside a run.
void draw_tag(const StageTag& tag, const auto& to_page, Sheet& sheet) {
  const TagPattern pattern = tag_pattern(tag.id);
  const auto& c = tag.corners_object;
  const auto at = [&](double column, double row) {  // bilinear between the corners
    const double u = column / kTagCells, v = row / kTagCells;
    return to_page(((1 - u) * c[0] + u * c[1]) * (1 - v) + ((1 - u) * c[3] + u * c[2]) * v);
  };
  for (int row = 0; row < kTagCells; ++row)
    for (int column = 0; column < kTagCells; ++column) {
      if (pattern.white[row][column]) continue;
      int end = column;
      while (end < kTagCells && !pattern.white[row][end]) ++end;
      sheet.polygons.push_back({{at(column, row), at(end, row), at(end, row + 1), at(column, row + 1)}, 0});
      column = end;
    }
  const Point below = to_page(c[3]);
  const double cell = (c[1] - c[0]).norm() * 1e3 / kTagCells;
  sheet.labels.push_back({below + Point(0, 0.75 * cell), std::min(2.2, 0.55 * cell), std::to_string(tag.id)});
}

Sheet draw(const StageLayout& stage) {
  Sheet sheet;
  const double board_width = stage.width_m * 1e3, board_height = stage.height_m * 1e3;
  sheet.width = std::max(board_width, kScaleBar) + 2 * kPageMargin;
  sheet.height = board_height + 2 * kPageMargin + kFooter;
  const auto to_page = [&](const Eigen::Vector3d& p) {
    return Point(kPageMargin + board_width / 2 + p.x() * 1e3, kPageMargin + board_height / 2 - p.y() * 1e3);
  };

  const Point low(kPageMargin, kPageMargin), high(kPageMargin + board_width, kPageMargin + board_height);
  const Point outline[] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  for (int i = 0; i < 4; ++i) sheet.strokes.push_back({outline[i], outline[(i + 1) % 4], 0.1, 0.6});
  for (const StageTag& tag : stage.tags) draw_tag(tag, to_page, sheet);

  constexpr double kAxis = 0.02;  // metres; pale, for the object stands on them
  const Point origin = to_page({0, 0, 0}), x_end = to_page({kAxis, 0, 0}), y_end = to_page({0, kAxis, 0});
  sheet.strokes.push_back({to_page({-kAxis / 4, 0, 0}), x_end, 0.2, 0.6});
  sheet.strokes.push_back({to_page({0, -kAxis / 4, 0}), y_end, 0.2, 0.6});
  sheet.labels.push_back({x_end + Point(1, 1), 3, "x"});
  sheet.labels.push_back({y_end + Point(-1, -1), 3, "y"});
  sheet.labels.push_back({origin + Point(1, 4), 2.5, "origin, z up"});

  const Point bar(kPageMargin, high.y() + 8);
  sheet.strokes.push_back({bar, bar + Point(kScaleBar, 0), 0.2, 0});
  for (int i = 0; i <= 10; ++i) {
    const Point foot = bar + Point(kScaleBar * i / 10, 0);
    sheet.strokes.push_back({foot, foot - Point(0, i % 5 == 0 ? 4 : 2), 0.2, 0});
  }
  sheet.labels.push_back({bar + Point(0, 4), 3, "100 mm between the outer marks: check with a ruler, print at 100 %"});
  const std::string caption = format("Sheen stage, %s, %zu tags, %g x %g mm, layout %s", stage.family.c_str(),
                                     stage.tags.size(), board_width, board_height, stage.hash().c_str());
  sheet.labels.push_back({bar + Point(0, 8), 3, caption});
  return sheet;
}

std::string svg(const Sheet& sheet) {
  const auto grey = [](double g) {
    const int level = static_cast<int>(g * 255 + 0.5);
    return format("#%02x%02x%02x", level, level, level);
  };
  const std::string w = number(sheet.width), h = number(sheet.height);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "mm\" height=\"" + h +
                    "mm\" viewBox=\"0 0 " + w + ' ' + h + "\">\n<rect width=\"" + w + "\" height=\"" + h +
                    "\" fill=\"#ffffff\"/>\n<g shape-rendering=\"geometricPrecision\">\n";
  for (const Polygon& p : sheet.polygons) {
    out += "<polygon fill=\"" + grey(p.grey) + "\" points=\"";
    for (const Point& c : p.corners) out += number(c.x()) + ',' + number(c.y()) + ' ';
    out += "\"/>\n";
  }
  for (const Stroke& s : sheet.strokes)
    out += "<line stroke=\"" + grey(s.grey) + "\" stroke-width=\"" + number(s.width) + "\" x1=\"" + number(s.from.x()) +
           "\" y1=\"" + number(s.from.y()) + "\" x2=\"" + number(s.to.x()) + "\" y2=\"" + number(s.to.y()) + "\"/>\n";
  for (const Label& l : sheet.labels)
    out += "<text font-family=\"Helvetica, Arial, sans-serif\" fill=\"#555555\" font-size=\"" + number(l.height) +
           "\" x=\"" + number(l.baseline.x()) + "\" y=\"" + number(l.baseline.y()) + "\">" + l.text + "</text>\n";
  return out + "</g>\n</svg>\n";
}

/// PDF page content: points of 1/72 inch, y up.
std::string pdf_content(const Sheet& sheet) {
  const auto place = [&](const Point& p) {
    return number(p.x() * kPointsPerMm) + ' ' + number((sheet.height - p.y()) * kPointsPerMm) + ' ';
  };
  std::string out;
  for (const Polygon& p : sheet.polygons) {
    out += number(p.grey) + " g ";
    for (std::size_t i = 0; i < p.corners.size(); ++i) out += place(p.corners[i]) + (i == 0 ? "m " : "l ");
    out += "h f\n";
  }
  for (const Stroke& s : sheet.strokes)
    out +=
        number(s.grey) + " G " + number(s.width * kPointsPerMm) + " w " + place(s.from) + "m " + place(s.to) + "l S\n";
  out += "0.33 g\n";
  for (const Label& l : sheet.labels)
    out += "BT /F1 " + number(l.height * kPointsPerMm) + " Tf " + place(l.baseline) + "Td (" + l.text + ") Tj ET\n";
  return out;
}

std::string pdf(const Sheet& sheet) {
  const std::string content = pdf_content(sheet);
  const std::string objects[] = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + number(sheet.width * kPointsPerMm) + ' ' +
          number(sheet.height * kPointsPerMm) + "] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>",
      "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "\nendstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
  };
  std::string out = "%PDF-1.4\n", table;
  int id = 0;
  for (const std::string& object : objects) {
    table += format("%010zu 00000 n \n", out.size());
    out += std::to_string(++id) + " 0 obj\n" + object + "\nendobj\n";
  }
  const std::string count = std::to_string(id + 1), start = std::to_string(out.size());
  return out + "xref\n0 " + count + "\n0000000000 65535 f \n" + table + "trailer\n<< /Size " + count +
         " /Root 1 0 R >>\nstartxref\n" + start + "\n%%EOF\n";
}

}  // namespace

BoardSize board_for_paper(double longer_m, double shorter_m) {
  return {longer_m - 2e-3 * kPageMargin, shorter_m - 1e-3 * (2 * kPageMargin + kFooter)};
}

void write_stage_sheet(const StageLayout& stage, const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending != ".pdf" && ending != ".svg")
    throw ConfigError("a stage is written as .pdf or .svg, not as \"" + path.filename().string() + "\"");
  const Sheet sheet = draw(stage);
  write_file(path, ending == ".pdf" ? pdf(sheet) : svg(sheet));
}

}  // namespace sheen
