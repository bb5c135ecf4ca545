// SPDX-License-Identifier: Apache-2.0
#include "common/stage/stage_sheet.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <sstream>

#include "common/base/errors.h"
#include "common/base/files.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr double kPixelsPerMm = 4;

/// A grey page, white at first, on which convex polygons are painted by testing every pixel's centre.
struct Page {
  int width, height;
  std::vector<std::uint8_t> pixels;

  Page(double width_mm, double height_mm)
      : width(int(std::lround(width_mm * kPixelsPerMm))),
        height(int(std::lround(height_mm * kPixelsPerMm))),
        pixels(std::size_t(width) * height, 255) {}

  void paint(const std::vector<Vector2d>& polygon_mm) {
    Vector2d low = polygon_mm[0], high = low;
    for (const Vector2d& p : polygon_mm) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (int y = int(low.y() * kPixelsPerMm) - 1; y <= high.y() * kPixelsPerMm + 1; ++y)
      for (int x = int(low.x() * kPixelsPerMm) - 1; x <= high.x() * kPixelsPerMm + 1; ++x) {
        if (x < 0 || y < 0 || x >= width || y >= height) continue;
        const Vector2d p((x + 0.5) / kPixelsPerMm, (y + 0.5) / kPixelsPerMm);
        bool left = true, right = true;
        for (std::size_t i = 0; i < polygon_mm.size(); ++i) {
          const Vector2d a = polygon_mm[i], b = polygon_mm[(i + 1) % polygon_mm.size()];
          const double side = (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
          left = left && side >= 0;
          right = right && side <= 0;
        }
        if (left || right) pixels[std::size_t(y) * width + x] = 0;
      }
  }
};

double value_after(const std::string& text, const std::string& key) {
  return std::stod(text.substr(text.find(key) + key.size()));
}

Page read_svg(const std::string& text) {
  Page page(value_after(text, "width=\""), value_after(text, "height=\""));
  EXPECT_NE(text.find("mm\" height=\""), std::string::npos) << "the page's size is in millimetres";
  for (auto at = text.find("<polygon"); at != std::string::npos; at = text.find("<polygon", at + 1)) {
    const auto from = text.find("points=\"", at) + 8;
    std::string list = text.substr(from, text.find('"', from) - from);
    std::ranges::replace(list, ',', ' ');
    std::istringstream in(list);
    std::vector<Vector2d> polygon;
    for (Vector2d p; in >> p.x() >> p.y();) polygon.push_back(p);
    page.paint(polygon);
  }
  return page;
}

/// Follows the file's cross-reference table to the page's content, as a viewer does, and paints its filled paths.
Page read_pdf(const std::string& text) {
  const auto table = std::stoul(text.substr(text.rfind("startxref") + 10));
  EXPECT_EQ(text.compare(table, 4, "xref"), 0);
  std::vector<std::size_t> offsets;
  std::istringstream entries(text.substr(table + 5));
  int first = 0, count = 0;
  entries >> first >> count;
  for (int i = 0; i < count; ++i) {
    std::string offset, generation, kind;
    entries >> offset >> generation >> kind;
    offsets.push_back(std::stoul(offset));
  }
  for (int i = 1; i < count; ++i) {
    const std::string head = std::to_string(i) + " 0 obj";
    EXPECT_EQ(text.compare(offsets[i], head.size(), head), 0);
  }
  std::istringstream box(text.substr(text.find("/MediaBox [") + 11));
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  box >> x0 >> y0 >> x1 >> y1;
  constexpr double kMm = 25.4 / 72;
  Page page(x1 * kMm, y1 * kMm);
  const auto length = static_cast<std::size_t>(value_after(text.substr(offsets[4]), "/Length "));
  const auto begin = text.find("stream\n", offsets[4]) + 7;
  EXPECT_EQ(text.compare(begin + length, 10, "\nendstream"), 0);
  std::istringstream content(text.substr(begin, length));
  std::vector<double> operands;
  std::vector<Vector2d> path;
  for (std::string token; content >> token;) {
    if (token.find_first_not_of("0123456789.-") == std::string::npos) {
      operands.push_back(std::stod(token));
      continue;
    }
    if (token == "m") path.clear();
    if (token == "m" || token == "l")
      path.emplace_back(operands[operands.size() - 2] * kMm, (y1 - operands.back()) * kMm);
    if (token == "f") page.paint(path);
    operands.clear();
  }
  return page;
}

/// Finds the layout's tags on the page, all of them, where they belong.
void expect_stage_on(Page& page, const StageLayout& stage) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector(apriltag_detector_create(),
                                                                                      apriltag_detector_destroy);
  apriltag_detector_add_family(detector.get(), family.get());
  image_u8_t image{.width = page.width, .height = page.height, .stride = page.width, .buf = page.pixels.data()};
  zarray_t* found = apriltag_detector_detect(detector.get(), &image);
  EXPECT_EQ(zarray_size(found), int(stage.tags.size()));
  std::vector<Vector2d> truth, shift;  // shift: from the board's middle to the page's corner, the same for all
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found, i, &detection);
    const StageTag* tag = stage.find(detection->id);
    ASSERT_TRUE(tag) << detection->id;
    for (int c = 0; c < 4; ++c) {
      // The detector lists bottom left first and goes counter-clockwise; pages run down.
      const Eigen::Vector3d& corner = tag->corners_object[3 - c];
      truth.emplace_back(corner.x() * 1e3, -corner.y() * 1e3);
      shift.push_back(Vector2d(detection->p[c][0], detection->p[c][1]) / kPixelsPerMm - truth.back());
    }
  }
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& s : shift) mean += s / double(shift.size());
  double along = 0, squares = 0;
  for (std::size_t k = 0; k < shift.size(); ++k) {
    EXPECT_LT((shift[k] - mean).norm(), 0.2) << "corner " << k;  // mm; a pixel is 0.25 mm
    along += truth[k].dot(shift[k] - mean);
    squares += truth[k].squaredNorm();
  }
  EXPECT_NEAR(along / squares, 0, 2e-4) << "the scale";
  apriltag_detections_destroy(found);
}

class StageSheet : public testing::TestWithParam<const char*> {
 protected:
  fs::path file() const { return fs::temp_directory_path() / ("sheen_sheet_" + std::to_string(getpid()) + GetParam()); }
  void TearDown() override { fs::remove(file()); }
};

TEST_P(StageSheet, ShowsTheTagsTrueToScale) {
  for (const StageOptions& options :
       {StageOptions{}, StageOptions{.width_m = 0.277, .height_m = 0.19, .tag_m = 0.025, .first_id = 40}}) {
    const StageLayout stage = make_stage(options);
    write_stage_sheet(stage, file());
    const std::string text = read_file(file());
    Page page = std::string(GetParam()) == ".pdf" ? read_pdf(text) : read_svg(text);
    expect_stage_on(page, stage);
  }
}

TEST_P(StageSheet, HasAScaleBarAndSaysWhatItIs) {
  const StageLayout stage = make_stage({});
  write_stage_sheet(stage, file());
  const std::string text = read_file(file());
  EXPECT_NE(text.find("100 mm between the outer marks"), std::string::npos);
  EXPECT_NE(text.find(stage.hash()), std::string::npos);
  // The bar's ends stand 100 mm apart, in the file's own units.
  const std::string bar = std::string(GetParam()) == ".pdf" ? "28.3465 " : "x1=\"10.0000\"";
  const std::string end = std::string(GetParam()) == ".pdf" ? "311.8110 " : "x2=\"110.0000\"";
  EXPECT_NE(text.find(bar), std::string::npos);
  EXPECT_NE(text.find(end), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Formats, StageSheet, testing::Values(".pdf", ".svg"));

TEST(StageSheetFile, AnIndependentPdfRendererAgrees) {
  if (std::system("pdftoppm -v >/dev/null 2>&1") != 0) GTEST_SKIP() << "pdftoppm (poppler-utils) is not installed";
  const StageLayout stage = make_stage({});
  const fs::path file = fs::temp_directory_path() / ("sheen_sheet_" + std::to_string(getpid()) + "_rendered.pdf");
  write_stage_sheet(stage, file);
  const std::string stem = file.string() + "_page";
  ASSERT_EQ(std::system(("pdftoppm -gray -singlefile -r 101.6 '" + file.string() + "' '" + stem + "'").c_str()), 0);
  std::ifstream in(stem + ".pgm", std::ios::binary);
  std::string magic;
  int width = 0, height = 0, white = 0;
  in >> magic >> width >> height >> white;
  in.get();
  Page page(width / kPixelsPerMm, height / kPixelsPerMm);  // 101.6 dpi are 4 pixels per millimetre
  in.read(reinterpret_cast<char*>(page.pixels.data()), std::streamsize(page.pixels.size()));
  fs::remove(stem + ".pgm");
  fs::remove(file);
  expect_stage_on(page, stage);
}

TEST(StageSheetFile, ErrorsAreClear) {
  EXPECT_THROW(write_stage_sheet(make_stage({}), "stage.png"), ConfigError);
  EXPECT_THROW(write_stage_sheet(make_stage({}), "/no/such/folder/stage.pdf"), FileError);
}

}  // namespace
}  // namespace sheen
