// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/figure.h"

#include <algorithm>
#include <chrono>

#include "common/base/format.h"
#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

std::string joined(const std::vector<std::string>& cells, const char* separator) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? separator : "") + cells[i];
  return line;
}

}  // namespace

ImageU8 mosaic(const std::vector<std::vector<ImageU8>>& rows) {
  const int w = rows.front().front().width(), h = rows.front().front().height();
  ImageU8 all(w * static_cast<int>(rows.front().size()), h * static_cast<int>(rows.size()), 3);
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const ImageU8& image = rows[r][c];
      const int left = static_cast<int>(c) * w, top = static_cast<int>(r) * h, last = image.channels() - 1;
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
          for (int k = 0; k < 3; ++k) all.at(left + x, top + y, k) = image.at(x, y, std::min(k, last));
    }
  return all;
}

std::string table_csv(const Figure::Table& table) {
  std::string text;
  const auto line = [&](std::vector<std::string> cells) {
    for (std::string& cell : cells) cell = csv_field(cell);
    text += joined(cells, ",") + '\n';
  };
  line(table.columns);
  for (const std::vector<std::string>& row : table.rows) line(row);
  return text;
}

std::string table_markdown(const Figure::Table& table) {
  std::string text = "| " + joined(table.columns, " | ") + " |\n|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += "---|";
  text += '\n';
  for (const std::vector<std::string>& row : table.rows) text += "| " + joined(row, " | ") + " |\n";
  return text;
}

double mean_psnr_db(const std::vector<HeldOutView>& views, const Appearance& model, const RayPainter& painter) {
  double sum = 0;
  for (const HeldOutView& view : views) sum += object_error(view, model, painter).psnr_db();
  return sum / static_cast<double>(views.size());
}

BatchRun build_batch(const Experiment& experiment, const FigureOptions& options, const BatchFactorization& how) {
  using Clock = std::chrono::steady_clock;
  const auto since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  BatchRun run;
  const double cpu = process_cpu_s();
  const Clock::time_point start = Clock::now();
  run.columns = std::make_unique<BatchLightField>(experiment.mesh, options.model);
  for (const Capture& capture : experiment.training) run.columns->add(capture);
  run.collect_s = since(start);
  const Clock::time_point last = Clock::now();
  run.model = run.columns->factorize(how);
  run.factorize_s = since(last);
  run.cpu_s = process_cpu_s() - cpu;
  run.psnr_db = mean_psnr_db(experiment.held_out, *fill_unseen(*run.model), *experiment.painter);
  return run;
}

}  // namespace sheen
