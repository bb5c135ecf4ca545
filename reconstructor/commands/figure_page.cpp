// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/figure_page.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/end_on_stop.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/image/image_io.h"

namespace sheen {

FigurePage::FigurePage(const std::filesystem::path& out, const std::string& name, std::vector<int> only,
                       const std::string& json)
    : out_(out), name_(name), only_(std::move(only)), report_(json) {
  check_writable_folder(out);
  make_folder(out / "images");
}

bool FigurePage::wanted(int number) const {
  return only_.empty() || std::count(only_.begin(), only_.end(), number) > 0;
}

std::string FigurePage::publish(const Figure& figure) {
  std::string section = format("\n## Figure %d: ", figure.number) + figure.title + "\n\n";
  section += "| the paper | here | holds |\n|---|---|---|\n| " + figure.paper + " | " + figure.ours + " | " +
             (figure.holds ? "yes" : "**no**") + " |\n\n";
  for (const auto& [file, plot] : figure.plots) {
    drawn_ = write_plot(plot, out_ / "images" / file) == PlotFiles::kDrawn && drawn_;
    section += "![" + plot.title + "](images/" + file + ".svg) ([table](images/" + file + ".csv))\n\n";
  }
  for (const Figure::Table& table : figure.tables) {
    write_file(out_ / "images" / (table.file + ".csv"), table_csv(table));
    section += table.caption + " ([table](images/" + table.file + ".csv)):\n\n" + table_markdown(table) + "\n";
  }
  for (const auto& [file, caption, image] : figure.pictures) {
    write_png(out_ / "images" / (file + ".png"), image);
    section += "![" + caption + "](images/" + file + ".png)\n*" + caption + "*\n\n";
  }
  return section;
}

void FigurePage::make(const Figures& all, std::string heading) {
  std::string page = std::move(heading);
  nlohmann::ordered_json findings = nlohmann::ordered_json::array();
  PartsUntilStop parts;
  {
    Progress progress("measuring", all.size());
    std::size_t done = 0;
    for (const auto& [number, run] : all) {
      if (wanted(number)) {
        const std::optional<Figure> figure = parts.result(run);
        if (!figure) break;
        page += publish(*figure);
        findings.push_back({{"figure", number},
                            {"title", figure->title},
                            {"paper", figure->paper},
                            {"here", figure->ours},
                            {"holds", figure->holds}});
        const ProgressPause pause;
        std::printf("figure %d, %s: %s\n  the paper: %s\n  here: %s\n", number, figure->title.c_str(),
                    figure->holds ? "holds" : "DOES NOT HOLD", figure->paper.c_str(), figure->ours.c_str());
        std::fflush(stdout);
      }
      progress.update(++done);
    }
  }
  write_file(out_ / name_, page);
  if (report_.wanted()) report_.write(nlohmann::ordered_json{{"figures", findings}}.dump(2) + "\n");
  if (!drawn_) std::fprintf(stderr, "%s\n", kInstallGnuplot);
  if (parts.stopped()) std::fprintf(stderr, "stopped after %zu figures, which are kept\n", findings.size());
}

}  // namespace sheen
